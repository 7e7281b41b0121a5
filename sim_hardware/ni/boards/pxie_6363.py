"""PXIe-6363: a PCIe-6363 for a PXI Express chassis, whose clocks it can lock to."""

from dataclasses import replace

from nidaqmx.constants import BusType

from sim_hardware.ni.boards import pcie_6363

BOARD = replace(
    pcie_6363.BOARD,
    product_type="PXIe-6363",
    product_number=None,
    bus=BusType.PXIE,
)
