"""The simulated operator of the rig: does in the simulated world what the program asks for."""

from __future__ import annotations

from drivers.interfaces import Prompt
from sim_hardware.world import World


class SimulatedOperator:
    """An `Operator` who never declines."""

    def __init__(self, world: World) -> None:
        self._world = world

    def ask(self, prompt: Prompt) -> bool:
        """Do it. A kind of request that this operator does not know is an error."""
        match prompt.kind:
            case "move" | "touch":
                self._place(prompt.position_m)
            case "free":
                self._world.place(None)
            case "moisten":
                self._world.moisten()
            case "mount":
                if prompt.configuration is None:
                    raise ValueError("asked to mount a sheet, but not which configuration")
                self._world.mount(prompt.configuration)
            case "remount":
                self._world.remount()
            case "dead_weight":
                self._world.hang(prompt.load_N or 0.0)
            case "turn_over":
                self._world.turn_over()
            case "confirm" | "repeat":  # it goes on
                pass
            case other:
                raise ValueError(f"the simulated operator does not know how to {other}")
        return True

    def _place(self, position_m: float | None) -> None:
        """From below, unless the load cell was further along the arc before."""
        before_m = self._world.position_m
        down = None not in (before_m, position_m) and before_m > position_m  # type: ignore[operator]
        self._world.place(position_m, "down" if down else "up")
