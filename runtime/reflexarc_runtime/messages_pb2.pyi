from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Verdict(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    VERDICT_UNSPECIFIED: _ClassVar[Verdict]
    OK: _ClassVar[Verdict]
    NO_INPUT: _ClassVar[Verdict]
    STALE_INPUT: _ClassVar[Verdict]
    INVALID_INPUT: _ClassVar[Verdict]
    RECOVERING: _ClassVar[Verdict]
    POLICY_FAULT: _ClassVar[Verdict]
    STOPPED: _ClassVar[Verdict]
    TWO_SOURCES: _ClassVar[Verdict]
    OVERRUN: _ClassVar[Verdict]
    GUARDED: _ClassVar[Verdict]
    STUCK: _ClassVar[Verdict]
VERDICT_UNSPECIFIED: Verdict
OK: Verdict
NO_INPUT: Verdict
STALE_INPUT: Verdict
INVALID_INPUT: Verdict
RECOVERING: Verdict
POLICY_FAULT: Verdict
STOPPED: Verdict
TWO_SOURCES: Verdict
OVERRUN: Verdict
GUARDED: Verdict
STUCK: Verdict

class Command(_message.Message):
    __slots__ = ("sequence", "action", "verdict", "linear_mps", "lateral_mps", "angular_radps", "valid_for_ns", "source_sequence", "source_time_ns", "body")
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    ACTION_FIELD_NUMBER: _ClassVar[int]
    VERDICT_FIELD_NUMBER: _ClassVar[int]
    LINEAR_MPS_FIELD_NUMBER: _ClassVar[int]
    LATERAL_MPS_FIELD_NUMBER: _ClassVar[int]
    ANGULAR_RADPS_FIELD_NUMBER: _ClassVar[int]
    VALID_FOR_NS_FIELD_NUMBER: _ClassVar[int]
    SOURCE_SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    SOURCE_TIME_NS_FIELD_NUMBER: _ClassVar[int]
    BODY_FIELD_NUMBER: _ClassVar[int]
    sequence: int
    action: int
    verdict: Verdict
    linear_mps: float
    lateral_mps: float
    angular_radps: float
    valid_for_ns: int
    source_sequence: int
    source_time_ns: int
    body: bytes
    def __init__(self, sequence: _Optional[int] = ..., action: _Optional[int] = ..., verdict: _Optional[_Union[Verdict, str]] = ..., linear_mps: _Optional[float] = ..., lateral_mps: _Optional[float] = ..., angular_radps: _Optional[float] = ..., valid_for_ns: _Optional[int] = ..., source_sequence: _Optional[int] = ..., source_time_ns: _Optional[int] = ..., body: _Optional[bytes] = ...) -> None: ...

class Input(_message.Message):
    __slots__ = ("sequence", "source_time_ns", "received_ns", "age_ns")
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    SOURCE_TIME_NS_FIELD_NUMBER: _ClassVar[int]
    RECEIVED_NS_FIELD_NUMBER: _ClassVar[int]
    AGE_NS_FIELD_NUMBER: _ClassVar[int]
    sequence: int
    source_time_ns: int
    received_ns: int
    age_ns: int
    def __init__(self, sequence: _Optional[int] = ..., source_time_ns: _Optional[int] = ..., received_ns: _Optional[int] = ..., age_ns: _Optional[int] = ...) -> None: ...

class Decision(_message.Message):
    __slots__ = ("index", "slot", "now_ns", "inputs", "input", "retina", "q_values", "action", "verdict", "reason", "command", "policy_hash", "winner", "state")
    INDEX_FIELD_NUMBER: _ClassVar[int]
    SLOT_FIELD_NUMBER: _ClassVar[int]
    NOW_NS_FIELD_NUMBER: _ClassVar[int]
    INPUTS_FIELD_NUMBER: _ClassVar[int]
    INPUT_FIELD_NUMBER: _ClassVar[int]
    RETINA_FIELD_NUMBER: _ClassVar[int]
    Q_VALUES_FIELD_NUMBER: _ClassVar[int]
    ACTION_FIELD_NUMBER: _ClassVar[int]
    VERDICT_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    COMMAND_FIELD_NUMBER: _ClassVar[int]
    POLICY_HASH_FIELD_NUMBER: _ClassVar[int]
    WINNER_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    index: int
    slot: int
    now_ns: int
    inputs: int
    input: Input
    retina: bytes
    q_values: _containers.RepeatedScalarFieldContainer[float]
    action: int
    verdict: Verdict
    reason: str
    command: Command
    policy_hash: str
    winner: int
    state: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, index: _Optional[int] = ..., slot: _Optional[int] = ..., now_ns: _Optional[int] = ..., inputs: _Optional[int] = ..., input: _Optional[_Union[Input, _Mapping]] = ..., retina: _Optional[bytes] = ..., q_values: _Optional[_Iterable[float]] = ..., action: _Optional[int] = ..., verdict: _Optional[_Union[Verdict, str]] = ..., reason: _Optional[str] = ..., command: _Optional[_Union[Command, _Mapping]] = ..., policy_hash: _Optional[str] = ..., winner: _Optional[int] = ..., state: _Optional[_Iterable[float]] = ...) -> None: ...

class Keyframe(_message.Message):
    __slots__ = ("index", "policy_hash", "streak", "newest", "frames", "fault", "memory", "hold", "stopped", "source", "ranges", "ranges_source", "moving", "ranges_fault", "backlog", "ranges_backlog", "still", "serving", "drove")
    INDEX_FIELD_NUMBER: _ClassVar[int]
    POLICY_HASH_FIELD_NUMBER: _ClassVar[int]
    STREAK_FIELD_NUMBER: _ClassVar[int]
    NEWEST_FIELD_NUMBER: _ClassVar[int]
    FRAMES_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    MEMORY_FIELD_NUMBER: _ClassVar[int]
    HOLD_FIELD_NUMBER: _ClassVar[int]
    STOPPED_FIELD_NUMBER: _ClassVar[int]
    SOURCE_FIELD_NUMBER: _ClassVar[int]
    RANGES_FIELD_NUMBER: _ClassVar[int]
    RANGES_SOURCE_FIELD_NUMBER: _ClassVar[int]
    MOVING_FIELD_NUMBER: _ClassVar[int]
    RANGES_FAULT_FIELD_NUMBER: _ClassVar[int]
    BACKLOG_FIELD_NUMBER: _ClassVar[int]
    RANGES_BACKLOG_FIELD_NUMBER: _ClassVar[int]
    STILL_FIELD_NUMBER: _ClassVar[int]
    SERVING_FIELD_NUMBER: _ClassVar[int]
    DROVE_FIELD_NUMBER: _ClassVar[int]
    index: int
    policy_hash: str
    streak: int
    newest: Accepted
    frames: _containers.RepeatedScalarFieldContainer[bytes]
    fault: str
    memory: Memory
    hold: Hold
    stopped: str
    source: Source
    ranges: Accepted
    ranges_source: Source
    moving: Moving
    ranges_fault: str
    backlog: Backlog
    ranges_backlog: Backlog
    still: Still
    serving: Serving
    drove: bool
    def __init__(self, index: _Optional[int] = ..., policy_hash: _Optional[str] = ..., streak: _Optional[int] = ..., newest: _Optional[_Union[Accepted, _Mapping]] = ..., frames: _Optional[_Iterable[bytes]] = ..., fault: _Optional[str] = ..., memory: _Optional[_Union[Memory, _Mapping]] = ..., hold: _Optional[_Union[Hold, _Mapping]] = ..., stopped: _Optional[str] = ..., source: _Optional[_Union[Source, _Mapping]] = ..., ranges: _Optional[_Union[Accepted, _Mapping]] = ..., ranges_source: _Optional[_Union[Source, _Mapping]] = ..., moving: _Optional[_Union[Moving, _Mapping]] = ..., ranges_fault: _Optional[str] = ..., backlog: _Optional[_Union[Backlog, _Mapping]] = ..., ranges_backlog: _Optional[_Union[Backlog, _Mapping]] = ..., still: _Optional[_Union[Still, _Mapping]] = ..., serving: _Optional[_Union[Serving, _Mapping]] = ..., drove: bool = ...) -> None: ...

class Serving(_message.Message):
    __slots__ = ("policy_hash", "former", "pending", "while_moving", "answered")
    POLICY_HASH_FIELD_NUMBER: _ClassVar[int]
    FORMER_FIELD_NUMBER: _ClassVar[int]
    PENDING_FIELD_NUMBER: _ClassVar[int]
    WHILE_MOVING_FIELD_NUMBER: _ClassVar[int]
    ANSWERED_FIELD_NUMBER: _ClassVar[int]
    policy_hash: str
    former: str
    pending: str
    while_moving: bool
    answered: bool
    def __init__(self, policy_hash: _Optional[str] = ..., former: _Optional[str] = ..., pending: _Optional[str] = ..., while_moving: bool = ..., answered: bool = ...) -> None: ...

class Swap(_message.Message):
    __slots__ = ("policy", "policy_hash", "reason", "while_moving")
    POLICY_FIELD_NUMBER: _ClassVar[int]
    POLICY_HASH_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    WHILE_MOVING_FIELD_NUMBER: _ClassVar[int]
    policy: bytes
    policy_hash: str
    reason: str
    while_moving: bool
    def __init__(self, policy: _Optional[bytes] = ..., policy_hash: _Optional[str] = ..., reason: _Optional[str] = ..., while_moving: bool = ...) -> None: ...

class SwapRequest(_message.Message):
    __slots__ = ("policy", "reason", "while_moving", "patience_s", "signature")
    POLICY_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    WHILE_MOVING_FIELD_NUMBER: _ClassVar[int]
    PATIENCE_S_FIELD_NUMBER: _ClassVar[int]
    SIGNATURE_FIELD_NUMBER: _ClassVar[int]
    policy: bytes
    reason: str
    while_moving: bool
    patience_s: float
    signature: bytes
    def __init__(self, policy: _Optional[bytes] = ..., reason: _Optional[str] = ..., while_moving: bool = ..., patience_s: _Optional[float] = ..., signature: _Optional[bytes] = ...) -> None: ...

class SwapAnswer(_message.Message):
    __slots__ = ("outcome", "words", "policy_hash", "tick")
    class Outcome(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        REFUSED: _ClassVar[SwapAnswer.Outcome]
        TAKEN: _ClassVar[SwapAnswer.Outcome]
        WAITING: _ClassVar[SwapAnswer.Outcome]
        ROLLED_BACK: _ClassVar[SwapAnswer.Outcome]
    REFUSED: SwapAnswer.Outcome
    TAKEN: SwapAnswer.Outcome
    WAITING: SwapAnswer.Outcome
    ROLLED_BACK: SwapAnswer.Outcome
    OUTCOME_FIELD_NUMBER: _ClassVar[int]
    WORDS_FIELD_NUMBER: _ClassVar[int]
    POLICY_HASH_FIELD_NUMBER: _ClassVar[int]
    TICK_FIELD_NUMBER: _ClassVar[int]
    outcome: SwapAnswer.Outcome
    words: str
    policy_hash: str
    tick: int
    def __init__(self, outcome: _Optional[_Union[SwapAnswer.Outcome, str]] = ..., words: _Optional[str] = ..., policy_hash: _Optional[str] = ..., tick: _Optional[int] = ...) -> None: ...

class Shadow(_message.Message):
    __slots__ = ("index", "policy_hash", "q_values", "winner", "action", "drove", "lead", "begins", "fault", "is_newer")
    INDEX_FIELD_NUMBER: _ClassVar[int]
    POLICY_HASH_FIELD_NUMBER: _ClassVar[int]
    Q_VALUES_FIELD_NUMBER: _ClassVar[int]
    WINNER_FIELD_NUMBER: _ClassVar[int]
    ACTION_FIELD_NUMBER: _ClassVar[int]
    DROVE_FIELD_NUMBER: _ClassVar[int]
    LEAD_FIELD_NUMBER: _ClassVar[int]
    BEGINS_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    IS_NEWER_FIELD_NUMBER: _ClassVar[int]
    index: int
    policy_hash: str
    q_values: _containers.RepeatedScalarFieldContainer[float]
    winner: int
    action: int
    drove: int
    lead: float
    begins: bool
    fault: str
    is_newer: bool
    def __init__(self, index: _Optional[int] = ..., policy_hash: _Optional[str] = ..., q_values: _Optional[_Iterable[float]] = ..., winner: _Optional[int] = ..., action: _Optional[int] = ..., drove: _Optional[int] = ..., lead: _Optional[float] = ..., begins: bool = ..., fault: _Optional[str] = ..., is_newer: bool = ...) -> None: ...

class Backlog(_message.Message):
    __slots__ = ("behind_ns", "stamp_ns", "received_ns", "least")
    BEHIND_NS_FIELD_NUMBER: _ClassVar[int]
    STAMP_NS_FIELD_NUMBER: _ClassVar[int]
    RECEIVED_NS_FIELD_NUMBER: _ClassVar[int]
    LEAST_FIELD_NUMBER: _ClassVar[int]
    behind_ns: int
    stamp_ns: int
    received_ns: int
    least: LeastDelay
    def __init__(self, behind_ns: _Optional[int] = ..., stamp_ns: _Optional[int] = ..., received_ns: _Optional[int] = ..., least: _Optional[_Union[LeastDelay, _Mapping]] = ...) -> None: ...

class LeastDelay(_message.Message):
    __slots__ = ("since_ns", "least_ns", "before_ns")
    SINCE_NS_FIELD_NUMBER: _ClassVar[int]
    LEAST_NS_FIELD_NUMBER: _ClassVar[int]
    BEFORE_NS_FIELD_NUMBER: _ClassVar[int]
    since_ns: int
    least_ns: int
    before_ns: int
    def __init__(self, since_ns: _Optional[int] = ..., least_ns: _Optional[int] = ..., before_ns: _Optional[int] = ...) -> None: ...

class Still(_message.Message):
    __slots__ = ("picture", "driven_ns", "told_ns")
    PICTURE_FIELD_NUMBER: _ClassVar[int]
    DRIVEN_NS_FIELD_NUMBER: _ClassVar[int]
    TOLD_NS_FIELD_NUMBER: _ClassVar[int]
    picture: bytes
    driven_ns: int
    told_ns: int
    def __init__(self, picture: _Optional[bytes] = ..., driven_ns: _Optional[int] = ..., told_ns: _Optional[int] = ...) -> None: ...

class Moving(_message.Message):
    __slots__ = ("twist", "commanded", "at_ns")
    TWIST_FIELD_NUMBER: _ClassVar[int]
    COMMANDED_FIELD_NUMBER: _ClassVar[int]
    AT_NS_FIELD_NUMBER: _ClassVar[int]
    twist: _containers.RepeatedScalarFieldContainer[float]
    commanded: _containers.RepeatedScalarFieldContainer[float]
    at_ns: int
    def __init__(self, twist: _Optional[_Iterable[float]] = ..., commanded: _Optional[_Iterable[float]] = ..., at_ns: _Optional[int] = ...) -> None: ...

class Source(_message.Message):
    __slots__ = ("sender", "heard_ns", "stranger_ns")
    SENDER_FIELD_NUMBER: _ClassVar[int]
    HEARD_NS_FIELD_NUMBER: _ClassVar[int]
    STRANGER_NS_FIELD_NUMBER: _ClassVar[int]
    sender: bytes
    heard_ns: int
    stranger_ns: int
    def __init__(self, sender: _Optional[bytes] = ..., heard_ns: _Optional[int] = ..., stranger_ns: _Optional[int] = ...) -> None: ...

class Accepted(_message.Message):
    __slots__ = ("sequence", "source_time_ns", "sender", "received_ns", "scan")
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    SOURCE_TIME_NS_FIELD_NUMBER: _ClassVar[int]
    SENDER_FIELD_NUMBER: _ClassVar[int]
    RECEIVED_NS_FIELD_NUMBER: _ClassVar[int]
    SCAN_FIELD_NUMBER: _ClassVar[int]
    sequence: int
    source_time_ns: int
    sender: bytes
    received_ns: int
    scan: AcceptedScan
    def __init__(self, sequence: _Optional[int] = ..., source_time_ns: _Optional[int] = ..., sender: _Optional[bytes] = ..., received_ns: _Optional[int] = ..., scan: _Optional[_Union[AcceptedScan, _Mapping]] = ...) -> None: ...

class AcceptedScan(_message.Message):
    __slots__ = ("start_rad", "end_rad", "ranges_m", "x_m", "y_m")
    START_RAD_FIELD_NUMBER: _ClassVar[int]
    END_RAD_FIELD_NUMBER: _ClassVar[int]
    RANGES_M_FIELD_NUMBER: _ClassVar[int]
    X_M_FIELD_NUMBER: _ClassVar[int]
    Y_M_FIELD_NUMBER: _ClassVar[int]
    start_rad: float
    end_rad: float
    ranges_m: _containers.RepeatedScalarFieldContainer[float]
    x_m: float
    y_m: float
    def __init__(self, start_rad: _Optional[float] = ..., end_rad: _Optional[float] = ..., ranges_m: _Optional[_Iterable[float]] = ..., x_m: _Optional[float] = ..., y_m: _Optional[float] = ...) -> None: ...

class Memory(_message.Message):
    __slots__ = ("now", "next")
    NOW_FIELD_NUMBER: _ClassVar[int]
    NEXT_FIELD_NUMBER: _ClassVar[int]
    now: _containers.RepeatedScalarFieldContainer[float]
    next: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, now: _Optional[_Iterable[float]] = ..., next: _Optional[_Iterable[float]] = ...) -> None: ...

class Hold(_message.Message):
    __slots__ = ("action", "since_slot")
    ACTION_FIELD_NUMBER: _ClassVar[int]
    SINCE_SLOT_FIELD_NUMBER: _ClassVar[int]
    action: int
    since_slot: int
    def __init__(self, action: _Optional[int] = ..., since_slot: _Optional[int] = ...) -> None: ...

class Stop(_message.Message):
    __slots__ = ("reason",)
    REASON_FIELD_NUMBER: _ClassVar[int]
    reason: str
    def __init__(self, reason: _Optional[str] = ...) -> None: ...

class Reset(_message.Message):
    __slots__ = ("reason",)
    REASON_FIELD_NUMBER: _ClassVar[int]
    reason: str
    def __init__(self, reason: _Optional[str] = ...) -> None: ...

class Arm(_message.Message):
    __slots__ = ("reason",)
    REASON_FIELD_NUMBER: _ClassVar[int]
    reason: str
    def __init__(self, reason: _Optional[str] = ...) -> None: ...

class Release(_message.Message):
    __slots__ = ("reason", "own")
    REASON_FIELD_NUMBER: _ClassVar[int]
    OWN_FIELD_NUMBER: _ClassVar[int]
    reason: str
    own: bool
    def __init__(self, reason: _Optional[str] = ..., own: bool = ...) -> None: ...

class HoldToRun(_message.Message):
    __slots__ = ("held", "body", "source_time_ns", "pressed_time_ns")
    HELD_FIELD_NUMBER: _ClassVar[int]
    BODY_FIELD_NUMBER: _ClassVar[int]
    SOURCE_TIME_NS_FIELD_NUMBER: _ClassVar[int]
    PRESSED_TIME_NS_FIELD_NUMBER: _ClassVar[int]
    held: bool
    body: bytes
    source_time_ns: int
    pressed_time_ns: int
    def __init__(self, held: bool = ..., body: _Optional[bytes] = ..., source_time_ns: _Optional[int] = ..., pressed_time_ns: _Optional[int] = ...) -> None: ...

class Overrun(_message.Message):
    __slots__ = ("since_ns", "late_ns", "ended_policy")
    SINCE_NS_FIELD_NUMBER: _ClassVar[int]
    LATE_NS_FIELD_NUMBER: _ClassVar[int]
    ENDED_POLICY_FIELD_NUMBER: _ClassVar[int]
    since_ns: int
    late_ns: int
    ended_policy: str
    def __init__(self, since_ns: _Optional[int] = ..., late_ns: _Optional[int] = ..., ended_policy: _Optional[str] = ...) -> None: ...

class Lease(_message.Message):
    __slots__ = ("holder", "epoch", "armed", "stopped", "state", "refused", "body", "held_by", "hold_to_run")
    class RefusedEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: int
        def __init__(self, key: _Optional[str] = ..., value: _Optional[int] = ...) -> None: ...
    HOLDER_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    ARMED_FIELD_NUMBER: _ClassVar[int]
    STOPPED_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    REFUSED_FIELD_NUMBER: _ClassVar[int]
    BODY_FIELD_NUMBER: _ClassVar[int]
    HELD_BY_FIELD_NUMBER: _ClassVar[int]
    HOLD_TO_RUN_FIELD_NUMBER: _ClassVar[int]
    holder: bytes
    epoch: int
    armed: bool
    stopped: str
    state: str
    refused: _containers.ScalarMap[str, int]
    body: bytes
    held_by: bytes
    hold_to_run: bool
    def __init__(self, holder: _Optional[bytes] = ..., epoch: _Optional[int] = ..., armed: bool = ..., stopped: _Optional[str] = ..., state: _Optional[str] = ..., refused: _Optional[_Mapping[str, int]] = ..., body: _Optional[bytes] = ..., held_by: _Optional[bytes] = ..., hold_to_run: bool = ...) -> None: ...

class Body(_message.Message):
    __slots__ = ("world", "world_text", "seed", "number", "step_s", "limits")
    WORLD_FIELD_NUMBER: _ClassVar[int]
    WORLD_TEXT_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    STEP_S_FIELD_NUMBER: _ClassVar[int]
    LIMITS_FIELD_NUMBER: _ClassVar[int]
    world: str
    world_text: str
    seed: int
    number: int
    step_s: float
    limits: BodyLimits
    def __init__(self, world: _Optional[str] = ..., world_text: _Optional[str] = ..., seed: _Optional[int] = ..., number: _Optional[int] = ..., step_s: _Optional[float] = ..., limits: _Optional[_Union[BodyLimits, _Mapping]] = ...) -> None: ...

class BodyLimits(_message.Message):
    __slots__ = ("linear_mps", "lateral_mps", "angular_radps", "acceleration_mps2", "valid_for_ns")
    LINEAR_MPS_FIELD_NUMBER: _ClassVar[int]
    LATERAL_MPS_FIELD_NUMBER: _ClassVar[int]
    ANGULAR_RADPS_FIELD_NUMBER: _ClassVar[int]
    ACCELERATION_MPS2_FIELD_NUMBER: _ClassVar[int]
    VALID_FOR_NS_FIELD_NUMBER: _ClassVar[int]
    linear_mps: float
    lateral_mps: float
    angular_radps: float
    acceleration_mps2: float
    valid_for_ns: int
    def __init__(self, linear_mps: _Optional[float] = ..., lateral_mps: _Optional[float] = ..., angular_radps: _Optional[float] = ..., acceleration_mps2: _Optional[float] = ..., valid_for_ns: _Optional[int] = ...) -> None: ...

class Timing(_message.Message):
    __slots__ = ("deadline_ns", "wake_ns", "lateness_ns", "receive_ns", "decide_ns", "publish_ns", "record_ns")
    DEADLINE_NS_FIELD_NUMBER: _ClassVar[int]
    WAKE_NS_FIELD_NUMBER: _ClassVar[int]
    LATENESS_NS_FIELD_NUMBER: _ClassVar[int]
    RECEIVE_NS_FIELD_NUMBER: _ClassVar[int]
    DECIDE_NS_FIELD_NUMBER: _ClassVar[int]
    PUBLISH_NS_FIELD_NUMBER: _ClassVar[int]
    RECORD_NS_FIELD_NUMBER: _ClassVar[int]
    deadline_ns: int
    wake_ns: int
    lateness_ns: int
    receive_ns: int
    decide_ns: int
    publish_ns: int
    record_ns: int
    def __init__(self, deadline_ns: _Optional[int] = ..., wake_ns: _Optional[int] = ..., lateness_ns: _Optional[int] = ..., receive_ns: _Optional[int] = ..., decide_ns: _Optional[int] = ..., publish_ns: _Optional[int] = ..., record_ns: _Optional[int] = ...) -> None: ...

class Tick(_message.Message):
    __slots__ = ("decision", "timing")
    DECISION_FIELD_NUMBER: _ClassVar[int]
    TIMING_FIELD_NUMBER: _ClassVar[int]
    decision: Decision
    timing: Timing
    def __init__(self, decision: _Optional[_Union[Decision, _Mapping]] = ..., timing: _Optional[_Union[Timing, _Mapping]] = ...) -> None: ...

class Status(_message.Message):
    __slots__ = ("node", "run_id", "policy_hash", "ticks", "rate_hz", "lateness_p50_ns", "lateness_p99_ns", "lateness_max_ns", "skipped_slots", "inbox_overflows", "verdicts", "recording", "guard", "watchdog", "sensor", "phases", "shadow", "action", "verdict", "policy", "pace", "contract_rate_hz", "is_stand_in", "realtime")
    class VerdictsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: int
        def __init__(self, key: _Optional[str] = ..., value: _Optional[int] = ...) -> None: ...
    NODE_FIELD_NUMBER: _ClassVar[int]
    RUN_ID_FIELD_NUMBER: _ClassVar[int]
    POLICY_HASH_FIELD_NUMBER: _ClassVar[int]
    TICKS_FIELD_NUMBER: _ClassVar[int]
    RATE_HZ_FIELD_NUMBER: _ClassVar[int]
    LATENESS_P50_NS_FIELD_NUMBER: _ClassVar[int]
    LATENESS_P99_NS_FIELD_NUMBER: _ClassVar[int]
    LATENESS_MAX_NS_FIELD_NUMBER: _ClassVar[int]
    SKIPPED_SLOTS_FIELD_NUMBER: _ClassVar[int]
    INBOX_OVERFLOWS_FIELD_NUMBER: _ClassVar[int]
    VERDICTS_FIELD_NUMBER: _ClassVar[int]
    RECORDING_FIELD_NUMBER: _ClassVar[int]
    GUARD_FIELD_NUMBER: _ClassVar[int]
    WATCHDOG_FIELD_NUMBER: _ClassVar[int]
    SENSOR_FIELD_NUMBER: _ClassVar[int]
    PHASES_FIELD_NUMBER: _ClassVar[int]
    SHADOW_FIELD_NUMBER: _ClassVar[int]
    ACTION_FIELD_NUMBER: _ClassVar[int]
    VERDICT_FIELD_NUMBER: _ClassVar[int]
    POLICY_FIELD_NUMBER: _ClassVar[int]
    PACE_FIELD_NUMBER: _ClassVar[int]
    CONTRACT_RATE_HZ_FIELD_NUMBER: _ClassVar[int]
    IS_STAND_IN_FIELD_NUMBER: _ClassVar[int]
    REALTIME_FIELD_NUMBER: _ClassVar[int]
    node: str
    run_id: str
    policy_hash: str
    ticks: int
    rate_hz: float
    lateness_p50_ns: int
    lateness_p99_ns: int
    lateness_max_ns: int
    skipped_slots: int
    inbox_overflows: int
    verdicts: _containers.ScalarMap[str, int]
    recording: str
    guard: str
    watchdog: str
    sensor: str
    phases: _containers.RepeatedCompositeFieldContainer[PhaseTimes]
    shadow: str
    action: str
    verdict: Verdict
    policy: str
    pace: str
    contract_rate_hz: float
    is_stand_in: bool
    realtime: str
    def __init__(self, node: _Optional[str] = ..., run_id: _Optional[str] = ..., policy_hash: _Optional[str] = ..., ticks: _Optional[int] = ..., rate_hz: _Optional[float] = ..., lateness_p50_ns: _Optional[int] = ..., lateness_p99_ns: _Optional[int] = ..., lateness_max_ns: _Optional[int] = ..., skipped_slots: _Optional[int] = ..., inbox_overflows: _Optional[int] = ..., verdicts: _Optional[_Mapping[str, int]] = ..., recording: _Optional[str] = ..., guard: _Optional[str] = ..., watchdog: _Optional[str] = ..., sensor: _Optional[str] = ..., phases: _Optional[_Iterable[_Union[PhaseTimes, _Mapping]]] = ..., shadow: _Optional[str] = ..., action: _Optional[str] = ..., verdict: _Optional[_Union[Verdict, str]] = ..., policy: _Optional[str] = ..., pace: _Optional[str] = ..., contract_rate_hz: _Optional[float] = ..., is_stand_in: bool = ..., realtime: _Optional[str] = ...) -> None: ...

class PhaseTimes(_message.Message):
    __slots__ = ("phase", "count", "p50_ns", "p99_ns", "p999_ns", "max_ns", "least_bits", "octaves", "sum_ns")
    PHASE_FIELD_NUMBER: _ClassVar[int]
    COUNT_FIELD_NUMBER: _ClassVar[int]
    P50_NS_FIELD_NUMBER: _ClassVar[int]
    P99_NS_FIELD_NUMBER: _ClassVar[int]
    P999_NS_FIELD_NUMBER: _ClassVar[int]
    MAX_NS_FIELD_NUMBER: _ClassVar[int]
    LEAST_BITS_FIELD_NUMBER: _ClassVar[int]
    OCTAVES_FIELD_NUMBER: _ClassVar[int]
    SUM_NS_FIELD_NUMBER: _ClassVar[int]
    phase: str
    count: int
    p50_ns: int
    p99_ns: int
    p999_ns: int
    max_ns: int
    least_bits: int
    octaves: _containers.RepeatedScalarFieldContainer[int]
    sum_ns: int
    def __init__(self, phase: _Optional[str] = ..., count: _Optional[int] = ..., p50_ns: _Optional[int] = ..., p99_ns: _Optional[int] = ..., p999_ns: _Optional[int] = ..., max_ns: _Optional[int] = ..., least_bits: _Optional[int] = ..., octaves: _Optional[_Iterable[int]] = ..., sum_ns: _Optional[int] = ...) -> None: ...

class Contact(_message.Message):
    __slots__ = ("count", "x_m", "y_m", "time_ns")
    COUNT_FIELD_NUMBER: _ClassVar[int]
    X_M_FIELD_NUMBER: _ClassVar[int]
    Y_M_FIELD_NUMBER: _ClassVar[int]
    TIME_NS_FIELD_NUMBER: _ClassVar[int]
    count: int
    x_m: float
    y_m: float
    time_ns: int
    def __init__(self, count: _Optional[int] = ..., x_m: _Optional[float] = ..., y_m: _Optional[float] = ..., time_ns: _Optional[int] = ...) -> None: ...

class Rejected(_message.Message):
    __slots__ = ("key", "encoding", "payload", "attachment", "reason", "payload_bytes")
    KEY_FIELD_NUMBER: _ClassVar[int]
    ENCODING_FIELD_NUMBER: _ClassVar[int]
    PAYLOAD_FIELD_NUMBER: _ClassVar[int]
    ATTACHMENT_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    PAYLOAD_BYTES_FIELD_NUMBER: _ClassVar[int]
    key: str
    encoding: str
    payload: bytes
    attachment: bytes
    reason: str
    payload_bytes: int
    def __init__(self, key: _Optional[str] = ..., encoding: _Optional[str] = ..., payload: _Optional[bytes] = ..., attachment: _Optional[bytes] = ..., reason: _Optional[str] = ..., payload_bytes: _Optional[int] = ...) -> None: ...
