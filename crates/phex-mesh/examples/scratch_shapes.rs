fn main() {
    for n in [
        "torus",
        "ellipsoid",
        "wave",
        "monkey-saddle",
        "hyperboloid",
        "b-spline",
        "catenoid",
        "sphere",
        "plane",
        "cylinder",
    ] {
        let s = phex_mesh::shapes::Shape::from_name(n, &[]).unwrap();
        let t = phex_mesh::shapes::triangulate_with_parameters(&s, &Default::default())
            .unwrap()
            .to_soup();
        phex_mesh::io::write_soup(format!("/tmp/shapes/{n}.obj").as_ref(), &t).unwrap();
    }
}
