"""Control of the force: controller.toml, the reference, and what they make of a schedule."""
