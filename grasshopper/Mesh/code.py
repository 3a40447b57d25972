#! python3
# r: phex
import phex.grasshopper as g
o, p, m, r, x = g.mesh(ghenv, Surface, Panels, Run, Tolerance, rotate=Rotate, boundary=Boundary, unit=Unit)
Outlines, Panels, Mesh, Report, Phex = o, p, m, r, x
