"""From a message to a retina: decoding images and range scans into what the policy sees."""
