//! What `phex` alone says.

/// What to do next, for a person who has just installed the program.
pub const START: &str = "phex covers a free-form surface with planar hexagonal panels.

  phex shape roof -o roof.obj                   makes a surface to try; or take one of yours (OBJ, PLY, STL, OFF)
  phex info roof.obj                            says what is in it, and how many panels suit it
  phex mesh roof.obj -n 300 -o panels.obj --html report.html
                                                makes panels, judges them, and shows them in a browser
  phex fab panels.obj --thickness 20mm -o workshop
                                                writes drawings and schedules for the workshop
  phex studio roof.obj                          does all of that on a page of this machine

`phex help` lists the commands, `phex help mesh` the options of one, `phex help terms` the words of the tables.
`phex doctor` says what this machine has. If a run ends with 3, 4 or 5, its last lines say why and what helps.
";
