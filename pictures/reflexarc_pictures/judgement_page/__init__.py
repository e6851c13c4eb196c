"""The page of a judgement: what a candidate does otherwise than the policy that drove, drawn."""
