"""An authority, certificates and rights for the bus of one robot; trying its doors; signing."""
