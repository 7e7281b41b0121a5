"""Tables with one fault each, and the tables of other programs that the requests name."""

from __future__ import annotations

HEAD = "configuration,position_mm,voltage_V,reading,force_mN\n"
CURVE = "configuration,position_mm,voltage_V,point,x_mm,y_mm\n"
TABLES = {
    "renamed.csv": "configuration,position_mm,U (V),reading,F\nlong,5,2,0,1\n",
    "mixed.txt": "configuration;position_mm;voltage_V;force_mN\nlong;5;2;1,5\nlong;5;-2;1.5\n",
    "units.txt": "configuration\tposition_mm\tvoltage_V\tforce (kg)\nlong\t5\t2\t1,5\n",
    "wrong_unit.csv": "configuration,position_mm,voltage_V,reading,F (V)\nlong,5,2,0,1\n",
    "twice.csv": HEAD + "long,5,2,0,1\nlong,5,2,0,1\n",
    "short.csv": HEAD + "long,5,2,0,1\nlong,5,2,0\n",
    "letters.csv": HEAD + "long,5,2,0,one\n",
    "unknown.csv": HEAD + "medium,5,2,0,1\n",
    "curves_one.csv": CURVE + "long,5,2,0,0,0\n",
    "same_place.csv": CURVE + "long,5,2,0,0,0\nlong,5,2,1,0,0\nlong,5,2,2,9,0\n",
    "signals.csv": "configuration,position_mm,time_s,drive_V\nlong,5,0,0\nlong,5,1,0\n",
    "falling.csv": (
        "configuration,position_mm,time_s,drive_V,run\nlong,5,0,0,0\nlong,5,1,0,0\nlong,5,0.5,0,0\n"
    ),
    "other.txt": "configuration;position_mm;voltage_V;force_mN\nlong;5,5;2;1,5\n",
    "wide.txt": "configuration;position_mm;voltage_V;force_mN\nlong;5;2;1,5;3;4\n",
    "header_only.csv": HEAD,
    "no_configuration.csv": "position_mm,voltage_V,reading,force_mN\n5,2,0,1\n",
    "negative_sd.csv": HEAD.replace("mN\n", "mN,sd_mN\n") + "long,5,2,0,1,-1\n",
    "none_in_mean.csv": HEAD.replace("mN\n", "mN,mean_of\n") + "long,5,2,0,1,0\n",
}
