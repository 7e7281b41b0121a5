"""PCI-6703: 16 static analog outputs, 8 digital lines."""

from nidaqmx.constants import BusType, ProductCategory

from sim_hardware.ni.boards.contract import AnalogOutputs, BoardModel, DigitalPort

BOARD = BoardModel(
    product_type="PCI-6703",
    product_number=0x2C90,
    category=ProductCategory.AO_SERIES,
    bus=BusType.PCI,
    analog_out=AnalogOutputs(channels=16, ranges_V=(10.0,), clocked=False),
    ports=(DigitalPort(8),),
)
