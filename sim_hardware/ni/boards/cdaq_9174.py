"""cDAQ-9174: a CompactDAQ chassis of four slots. It times what its modules measure."""

from nidaqmx.constants import BusType, ProductCategory

from sim_hardware.ni.boards.contract import BoardModel

BOARD = BoardModel(
    product_type="cDAQ-9174",
    product_number=None,
    category=ProductCategory.COMPACT_DAQ_CHASSIS,
    bus=BusType.USB,
    slots=4,
)
