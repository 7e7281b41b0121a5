"""USB-6211: 16 analog inputs at 250 kS/s, 2 analog outputs, 4 digital inputs and 4 outputs."""

from nidaqmx.constants import BusType, ProductCategory

from sim_hardware.ni.boards.contract import AnalogInputs, AnalogOutputs, BoardModel, DigitalPort

BOARD = BoardModel(
    product_type="USB-6211",
    product_number=None,
    category=ProductCategory.M_SERIES_DAQ,
    bus=BusType.USB,
    analog_in=AnalogInputs(
        channels=16,
        ranges_V=(0.2, 1.0, 5.0, 10.0),
        noise_V=(11.8e-6, 30e-6, 122e-6, 244e-6),
        max_rate_hz=250e3,
        max_multi_rate_hz=250e3,
        min_rate_hz=20e6 / 2**32,
        timebase_hz=20e6,
        fifo_samples=4095,
    ),
    analog_out=AnalogOutputs(
        channels=2,
        ranges_V=(10.0,),
        clocked=True,
        max_rate_hz=250e3,
        fifo_samples=8191,
        keeps_voltage_on_reset=False,
    ),
    ports=(DigitalPort(4, outputs=False), DigitalPort(4, inputs=False)),
)
