"""A folder of photographs behind the page: measured one after the other, corrected, decided on."""
