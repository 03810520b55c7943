from lumped.drawing.film import animate as animate
from lumped.drawing.page import report_html as report_html
from lumped.drawing.schematic import schematic as schematic
from lumped.drawing.torsional_report import torsional_report as torsional_report
