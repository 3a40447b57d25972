//! Runs on one surface that is kept between them: `session_runs SURFACE [PANELS:DEGREES]...`.
//!
//! Each run has so many panels, and rows turned by so many degrees. `cargo xtask performance` takes
//! the processor time of the whole, and so finds what a session spares.

use phex::{MeshOptions, PanelSize, Session, Silent, Surface};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let file = words.next().ok_or("the file of a surface is missing")?;
    let session = Session::new(Surface::read(file)?);
    for word in words {
        let (panels, degrees) = word.split_once(':').ok_or("a run is PANELS:DEGREES")?;
        let mut options = MeshOptions {
            size: PanelSize::Panels(panels.parse()?),
            ..Default::default()
        };
        options.directions.rotate = degrees.parse::<f64>()?.to_radians();
        let run = session.run(&options, &Silent)?;
        let panels = run.mesh.topology().n_faces();
        println!("{word}: {panels} panels, sound: {}", run.is_sound());
    }
    Ok(())
}
