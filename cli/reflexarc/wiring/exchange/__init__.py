"""What logs exchange with other tools: bags, tables, viewers."""
