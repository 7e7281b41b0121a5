"""Run, record and understand force and shape experiments on ionic-polymer actuator sheets."""
