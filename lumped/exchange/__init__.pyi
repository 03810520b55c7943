from lumped.compiler.parameter_file import read_parameters as read_parameters
from lumped.compiler.parameter_file import write_parameters as write_parameters
from lumped.exchange.fmu import ExportedFMU as ExportedFMU
from lumped.exchange.fmu import export_fmu as export_fmu
from lumped.exchange.modelica import export_modelica as export_modelica
