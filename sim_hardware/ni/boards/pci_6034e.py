"""PCI-6034E: 16 analog inputs at 200 kS/s, 8 digital lines.

Noise: a third of the maker's 'noise + quantization, single point'.
"""

from nidaqmx.constants import BusType, ProductCategory

from sim_hardware.ni.boards.contract import AnalogInputs, BoardModel, DigitalPort

BOARD = BoardModel(
    product_type="PCI-6034E",
    product_number=0x2CA0,
    category=ProductCategory.E_SERIES_DAQ,
    bus=BusType.PCI,
    analog_in=AnalogInputs(
        channels=16,
        ranges_V=(0.05, 0.5, 5.0, 10.0),
        noise_V=(9.6e-6, 19e-6, 156e-6, 311e-6),
        max_rate_hz=200e3,
        max_multi_rate_hz=200e3,
        min_rate_hz=100e3 / 2**24,
        timebase_hz=20e6,
        fifo_samples=512,
    ),
    ports=(DigitalPort(8),),
)
