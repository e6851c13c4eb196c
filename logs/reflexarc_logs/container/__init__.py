"""The MCAP file: records, chunks, metadata, writing under a temporary name."""
