#! python3
# r: phex
import phex.grasshopper as g
Report = g.report(ghenv, Mesh, Path, Run)
