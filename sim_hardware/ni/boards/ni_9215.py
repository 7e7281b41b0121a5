"""NI 9215: a C Series module of 4 analog inputs of 16 bits, sampled together, 100 kS/s each."""

from nidaqmx.constants import BusType, ProductCategory

from sim_hardware.ni.boards.contract import AnalogInputs, BoardModel, Terminals

BOARD = BoardModel(
    product_type="NI 9215",
    product_number=None,
    category=ProductCategory.C_SERIES_MODULE,
    bus=BusType.COMPACT_DAQ,
    analog_in=AnalogInputs(
        channels=4,
        ranges_V=(10.0,),
        noise_V=(0.4e-3,),  # 1.2 LSB rms of the range of 10.4 V, the maker's figure
        max_rate_hz=100e3,
        max_multi_rate_hz=100e3,
        min_rate_hz=80e6 / 2**32,
        timebase_hz=80e6,  # the chassis has the timing engine
        fifo_samples=127,
        terminals=(Terminals.DIFFERENTIAL,),
        pair_offset=0,
        simultaneous=True,
        settling_s=0.0,
    ),
    in_chassis=True,
)
