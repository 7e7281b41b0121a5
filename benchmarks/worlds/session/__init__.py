"""Sessions in one layout, for generators that like it; each solves the sheet by itself."""
