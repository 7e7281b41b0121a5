"""The sheet in time: mass, loss, fluid, electrodes, contact."""
