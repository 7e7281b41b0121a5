"""What `labrig init --board labjack` writes about the device."""

from drivers.boards.contract import Starter

STARTER = Starter(
    table="""\
[labjack]
address = "192.0.2.7"              # of the device on the network
model = "T7"                       # T4, T7 or T8; another one is refused
# serial = 470012345               # then a device with another serial number is refused
drive = "TDAC0"                    # LJTick-DAC on FIO0/FIO1: ±10 V; drives the amplifier
# drive = "DAC0"                   # the device's own output, 0 to 5 V: only behind a stage
# zero_V = 2.5                     # what DAC0 puts out for 0 V at the sheet
# stage_gain = 4.0                 # the stage puts out 4 * (DAC0 - 2.5 V)
force = "AIN0"                     # load cell; T7: differential with AIN1
current = "AIN2"                   # across the current shunt; T7: differential with AIN3
drive_readback = "AIN4"            # the amplifier's output: sheet volts; T7: with AIN5
sample_rate_hz = 1000.0            # of each channel
ranges_V = { force = 0.05, current = 0.5, drive = 5.0 }
""",
    simulated_table="""\
[labjack]
address = "simulated"
model = "T7"
drive = "TDAC0"                    # LJTick-DAC on FIO0/FIO1: ±10 V; drives the amplifier
force = "AIN0"                     # load cell, differential with AIN1
current = "AIN2"                   # across the current shunt, differential with AIN3
drive_readback = "AIN4"            # the amplifier's output: sheet volts, differential with AIN5
sample_rate_hz = 1000.0            # of each channel
""",
    interlock="""\
# [interlock]                      # a relay, not a one-shot: see docs/explanation/safety.md
# line = "EIO0"                    # high while a run is under way; the device's watchdog drops it
""",
    trigger_line="EIO1",
)
