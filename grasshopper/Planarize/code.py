#! python3
# r: phex
import phex.grasshopper as g
o, p, m, r, x = g.planarize(ghenv, Mesh, Surface, Run)
Outlines, Panels, Mesh, Report, Phex = o, p, m, r, x
