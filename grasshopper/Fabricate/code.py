#! python3
# r: phex
import phex.grasshopper as g
Report = g.fabricate(ghenv, Mesh, Folder, Run, thickness=Thickness, gap=Gap, side=Side, sheet=Sheet, unit=Unit)
