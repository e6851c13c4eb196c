"""One node on one log: what it says, compared with what was recorded on its topic."""

from dataclasses import dataclass
from pathlib import Path

from reflexarc_logs.diffing.diff import USUAL_RULES, diff_messages
from reflexarc_logs.diffing.diff_rules import DiffRules
from reflexarc_logs.diffing.message_file import StreamMessage
from reflexarc_logs.nodes.node_class import NamedNode, NodeError
from reflexarc_logs.nodes.node_input import NodeInput, is_of_another_system
from reflexarc_logs.nodes.node_report import NodeReport
from reflexarc_logs.nodes.node_run import NodeRun
from reflexarc_logs.nodes.recorded_anew import record_anew


@dataclass(frozen=True)
class NodeCheck:
    """A node, and how far its words may be from what was recorded.

    Args:
        named: the node.
        rules: what is passed over, how far values may lie apart, by what messages are paired.
        rules_name: what the rules' file is called; empty: there is none.
    """

    named: NamedNode
    rules: DiffRules = USUAL_RULES
    rules_name: str = ""

    def report(self, path: Path) -> NodeReport:
        """Feed the node from a log, and compare.

        Raises:
            NodeError, NodeCrashError, LogError: see `NodeRun`; or the log cannot be read.
        """
        return self._compared(NodeInput(path), path)[0]

    def record_anew(self, path: Path) -> NodeReport:
        """Put what the node says in the place of what was recorded, if that is not the same.

        Returns:
            Old beside new.

        Raises:
            NodeError: the log is ours: it is the record of a run, and its commands are those of
                its ticks; or it is cut; or the node does not say the same twice.
        """
        heard = NodeInput(path)
        report, said = self._compared(heard, path)
        if report.is_same:
            return report
        if not is_of_another_system(path):
            raise NodeError(f"{path}: only a whole log of another system is recorded anew")
        if said != self._compared(heard, path)[1]:
            raise NodeError(
                f"{self.named.name} does not say the same twice of {path}: it depends on more than "
                "its messages (random numbers, a clock); nothing was recorded"
            )
        record_anew(path, self.named.topic, said)
        return report

    def _compared(self, heard: NodeInput, path: Path) -> tuple[NodeReport, list[StreamMessage]]:
        topic = self.named.topic
        recorded = heard.recorded(topic)
        stream = recorded[0].stream if recorded else None
        run = NodeRun(self.named, heard, stream)
        sides = (lambda: recorded, lambda: run.outputs)
        found = diff_messages((str(path), self.named.name), sides, self.rules)
        known = stream or next((message.stream for message in run.outputs), None)
        report = NodeReport(
            path=str(path),
            node=self.named.name,
            topic=topic,
            first_ns=heard.first_ns,
            fed=run.fed,
            others=run.others,
            diff=found,
            tolerances=() if known is None else self.rules.tolerances(known),
            rules=self.rules_name,
            was_cut=heard.was_cut,
        )
        return report, run.outputs
