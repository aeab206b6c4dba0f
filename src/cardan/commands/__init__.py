"""Commands that stand by themselves: read, ask, print. `cardan.cli` registers them."""
