"""Messages on the bus: the table of topics, the wire format, the protobuf codec."""
