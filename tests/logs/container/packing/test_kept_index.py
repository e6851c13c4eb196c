import random

from reflexarc_logs.container.packing.kept_index import KeptIndex


def test_all_records_come_back_in_their_order_and_take_less():
    kept, bits = KeptIndex(), random.Random(5)
    records = [b"record %d of %d; " % (n, bits.randrange(1000)) * 8 for n in range(5000)]
    for record in records:
        kept.add(record)
    blocks = list(kept.blocks())
    assert b"".join(blocks) == b"".join(records)
    assert len(blocks) > 5  # it was packed in between
    assert kept.count == 5000
    assert list(kept.blocks()) == blocks  # asked again, nothing is lost


def test_none_at_all():
    assert b"".join(KeptIndex().blocks()) == b""
