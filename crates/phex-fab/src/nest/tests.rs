//! Panels that are pushed, exchanged and squeezed, on sheets where the answer is known.

use super::body::Body;
use super::exchange::Exchange;
use super::separate::Crowd;
use super::squeeze::squeeze;
use super::{Border, Placement, SheetLayout};
use phex_mesh::Vec2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const TOLERANCE: f64 = 1e-3;

fn square(side: f64, angles: Option<Vec<f64>>) -> Body {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let piece = corners.map(|[x, y]| Vec2::new(x, y) * side).to_vec();
    Body::new(&[piece], angles)
}

fn border(x: f64, y: f64) -> Border {
    Border {
        low: Vec2::zeros(),
        high: Vec2::new(x, y),
    }
}

fn at(plate: usize, x: f64, y: f64, rotation: f64) -> Placement {
    Placement {
        plate,
        rotation,
        translation: Vec2::new(x, y),
    }
}

fn exchange<'a>(bodies: &'a [Body], border: &'a Border) -> Exchange<'a> {
    Exchange {
        bodies,
        border,
        effort: 40,
        tolerance: TOLERANCE,
    }
}

/// The largest overlap, and how far panels reach along the sheet.
fn judge(sheet: &SheetLayout, bodies: &[Body], border: &Border) -> (f64, f64) {
    let posed: Vec<_> = sheet.iter().map(|p| bodies[p.plate].placed(p)).collect();
    let corners = || posed.iter().flat_map(|p| p.corners());
    let beyond = corners().map(|p| (border.low - p).sup(&(p - border.high)).max());
    let mut deepest = beyond.fold(0.0, f64::max);
    for (i, a) in posed.iter().enumerate() {
        let depths = posed[..i]
            .iter()
            .flat_map(|b| a.contacts(b))
            .map(|c| c.depth);
        deepest = depths.fold(deepest, f64::max);
    }
    (deepest, corners().map(|p| p.x).fold(0.0, f64::max))
}

#[test]
fn squares_on_top_of_one_another_come_apart_or_have_no_place() {
    let body = square(100.0, None);
    for (size, fits) in [(230.0, true), (180.0, false)] {
        let border = border(size, size);
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut crowd = Crowd::new(&border, TOLERANCE);
        for k in 0..4 {
            let near = Vec2::new(100.0 + f64::from(k), 110.0 - f64::from(k * k));
            crowd.push(&body, body.posed(near, 0.1 * f64::from(k)));
        }
        assert_eq!(
            crowd.separate(&mut random),
            fits,
            "four squares of 100 on {size}"
        );
        if fits {
            let layout: SheetLayout = crowd.posed.iter().map(|p| body.placement(0, p)).collect();
            let bodies = [body.clone()];
            assert!(judge(&layout, &bodies, &border).0 <= TOLERANCE);
        }
    }
}

#[test]
fn a_sheet_gets_fuller_and_no_panel_is_lost() {
    let bodies: Vec<Body> = [100.0, 60.0, 100.0, 100.0, 100.0]
        .map(|s| square(s, None))
        .to_vec();
    let border = border(230.0, 230.0);
    let sheet = vec![at(0, 60.0, 40.0, 0.3), at(1, 0.0, 160.0, 0.0)];
    let fuller = exchange(&bodies, &border).fill(sheet, vec![2, 3, 4], 0);
    let mut plates: Vec<usize> = fuller.iter().map(|p| p.plate).collect();
    plates.sort_unstable();
    assert_eq!(plates, [0, 2, 3, 4], "the small one makes room");
    assert!(judge(&fuller, &bodies, &border).0 <= TOLERANCE);
}

#[test]
fn a_last_sheet_gets_shorter_and_allowed_angles_are_kept() {
    let bodies = vec![square(100.0, Some(vec![0.0])); 3];
    let border = border(1000.0, 160.0);
    let sheet = vec![
        at(0, 0.0, 0.0, 0.0),
        at(1, 300.0, 50.0, 0.0),
        at(2, 800.0, 20.0, 0.0),
    ];
    let shorter = squeeze(sheet, &exchange(&bodies, &border));
    let (deepest, reach) = judge(&shorter, &bodies, &border);
    assert!(deepest <= TOLERANCE && reach < 305.0, "{deepest} {reach}");
    assert!(shorter.iter().all(|p| p.rotation == 0.0));
}
