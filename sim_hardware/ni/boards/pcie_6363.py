"""PCIe-6363: 32 analog inputs (2 MS/s, 1 MS/s of several), 4 analog outputs, 48 digital lines."""

from nidaqmx.constants import BusType, ProductCategory

from sim_hardware.ni.boards.contract import AnalogInputs, AnalogOutputs, BoardModel, DigitalPort

BOARD = BoardModel(
    product_type="PCIe-6363",
    product_number=0x7435,
    category=ProductCategory.X_SERIES_DAQ,
    bus=BusType.PCIE,
    analog_in=AnalogInputs(
        channels=32,
        ranges_V=(0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0),
        noise_V=(6e-6, 8e-6, 14e-6, 26e-6, 52e-6, 134e-6, 271e-6),
        max_rate_hz=2e6,
        max_multi_rate_hz=1e6,
        min_rate_hz=100e6 / 2**32,
        timebase_hz=100e6,
        fifo_samples=2047,
    ),
    analog_out=AnalogOutputs(
        channels=4,
        ranges_V=(5.0, 10.0),
        clocked=True,
        max_rate_hz=100e6 / 35,
        timebase_hz=100e6,
        fifo_samples=8191,
        keeps_voltage_on_reset=False,
    ),
    ports=(DigitalPort(32, buffered=True), DigitalPort(8), DigitalPort(8)),
)
