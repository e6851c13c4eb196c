"""From sensor messages to retinas: images and range scans become what the policy sees."""
