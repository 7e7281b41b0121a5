"""The sheet in time: a chain of links with mass, loss and electrodes, stepped on a fixed grid."""
