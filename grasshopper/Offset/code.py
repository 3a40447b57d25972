#! python3
# r: phex
import phex.grasshopper as g
layers = g.offset(ghenv, Mesh, Distance, Run, kind=Kind or 'face')
Outlines, Report, Phex = [o for s in layers for o in s.outlines], [s.report for s in layers], [s.phex for s in layers]
