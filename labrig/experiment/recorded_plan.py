"""The plan of a session that is resumed or replayed, from the files that the session holds."""

from __future__ import annotations

from labrig.config import RigConfig
from labrig.errors import BadInputError
from labrig.experiment.plan import Plan, make_plan
from labrig.experiment.rig.parts_in_use import missing_parts
from labrig.session import RecordedSession


def plan_of_session(session: RecordedSession, rig: RigConfig) -> Plan:
    """Return the plan on `rig`; BadInputError names the session, and parts that it lacks here.

    Hooks and published documents are left out: a file that comes from elsewhere must neither run
    commands here nor write where it likes.
    """
    rig = rig.model_copy(update={"hooks": None, "publish": None})
    names = {name: f"{session.path}: {name}" for name in session.texts}
    try:
        return make_plan(rig, session.texts, names)
    except BadInputError as error:
        missing = missing_parts(session.versions)
        if not missing:
            raise
        raise BadInputError(f"{session.path}: {missing}. {error}") from error
