#! python3
# r: phex
import phex.grasshopper as g
o, p, m, r, x = g.check(ghenv, Mesh, Surface)
Outlines, Panels, Mesh, Report, Phex = o, p, m, r, x
