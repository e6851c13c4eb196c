"""The assessment procedure as data: suites, families, cells and who is measured in them."""
