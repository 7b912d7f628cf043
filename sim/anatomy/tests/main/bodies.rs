//! Bodies over seeds: closed, apart, in the skin, in order, and the same each time.

use anatomy::{AnatomyPart, Body, BodyOrder, BodyQuality, BodySide, Level, Posture, Tissue, check_manifold, volume_m3};

fn order(seed: u64) -> BodyOrder {
    let [least, most] = anatomy::WEIGHTS_KG;
    let share = (seed * 7 % 20) as f64 / 19.0;
    BodyOrder {
        posture: Posture::ALL[(seed % 3) as usize],
        seed,
        weight_kg: least + (most - least) * share,
        age_years: 18.0 + 77.0 * ((seed * 11 % 20) as f64 / 19.0),
    }
}

fn bones() -> Vec<AnatomyPart> {
    AnatomyPart::list().into_iter().filter(|p| p.kind() == Some(law::structures::StructureKind::Bone)).collect()
}

#[test]
fn every_body_part_is_a_closed_manifold_that_faces_outward() {
    for seed in 0..40 {
        let body = Body::new(&order(seed)).unwrap();
        for part in AnatomyPart::list() {
            let mesh = body.mesh(part, BodyQuality::Low);
            assert_eq!(check_manifold(&mesh.triangles), Ok(0), "{} of {:?}", part.name(), body.order());
            assert!(volume_m3(&mesh.vertices_m, &mesh.triangles) > 0.0, "{} of {:?}", part.name(), body.order());
        }
    }
}

#[test]
fn the_best_quality_keeps_within_its_triangles() {
    for seed in [1, 5, 12] {
        let body = Body::new(&order(seed)).unwrap();
        let all: usize = AnatomyPart::list().iter().map(|p| body.mesh(*p, BodyQuality::Best).triangles.len()).sum();
        assert!((80_000..=200_000).contains(&all), "{all} triangles of {:?}", body.order());
    }
}

/// Every so many vertices of a part lie in the skin, and no deeper in another bone than `deepest_m`.
fn lies_apart(body: &Body, part: AnatomyPart, quality: BodyQuality, deepest_m: f64) {
    for vertex in body.mesh(part, quality).vertices_m.iter().step_by(3) {
        let of = || format!("{} of {:?} at {vertex}", part.name(), body.order());
        assert!(body.distance_m(AnatomyPart::Skin, vertex) < 0.0, "out of the skin: {}", of());
        if bones().contains(&part) {
            let other = bones().into_iter().find(|o| *o != part && body.distance_m(*o, vertex) < -deepest_m);
            assert_eq!(other, None, "{}", of());
        }
    }
}

#[test]
fn no_bone_goes_through_another_at_the_best_quality() {
    for seed in [0, 8, 13, 19] {
        let body = Body::new(&order(seed)).unwrap();
        bones().into_iter().for_each(|bone| lies_apart(&body, bone, BodyQuality::Best, 0.0));
    }
}

#[test]
fn parts_lie_in_the_skin_and_coarse_bones_overlap_within_a_cell() {
    for seed in 0..40 {
        let body = Body::new(&order(seed)).unwrap();
        let inner = AnatomyPart::list().into_iter().filter(|part| *part != AnatomyPart::Skin);
        inner.for_each(|part| lies_apart(&body, part, BodyQuality::Low, 0.003));
    }
}

#[test]
fn the_sac_has_room_in_the_canal() {
    for seed in 0..40 {
        let body = Body::new(&order(seed)).unwrap();
        let sac = body.mesh(AnatomyPart::DuralSac, BodyQuality::Low);
        for vertex in &sac.vertices_m {
            let column = Level::ALL.map(AnatomyPart::Vertebra);
            let bone = column.into_iter().find(|bone| body.distance_m(*bone, vertex) < 0.0);
            assert_eq!(bone, None, "{:?} at {vertex}", body.order());
        }
    }
}

#[test]
fn tissues_along_a_free_midline_path_come_in_their_order() {
    let rank = |tissue: Tissue| match tissue {
        Tissue::Skin => Some(0),
        Tissue::Part(AnatomyPart::Supraspinous) => Some(1),
        Tissue::Part(AnatomyPart::Interspinous(_)) => Some(2),
        Tissue::Part(AnatomyPart::Flavum(_)) => Some(3),
        Tissue::Part(AnatomyPart::EpiduralSpace) => Some(4),
        Tissue::Part(AnatomyPart::DuralSac) => Some(5),
        _ => None,
    };
    let mut free = 0;
    for seed in 0..40 {
        let body = Body::new(&order(seed)).unwrap();
        for level in Level::ALL {
            let path = body.midline_path(level, 0.0);
            if path.to_flavum_m.is_none() {
                continue;
            }
            free += 1;
            let layers = body.list_layers(&path.entry_m, &path.direction, 0.2);
            assert!(layers.windows(2).all(|pair| (pair[0].to_m - pair[1].from_m).abs() < 1e-6));
            let ranks: Vec<i32> = layers.iter().filter_map(|layer| rank(layer.tissue)).collect();
            let to_sac = ranks.iter().position(|rank| *rank == 5).expect("a path through the flavum reaches the sac");
            assert!(ranks[..to_sac].is_sorted(), "{ranks:?} at {} of {:?}", level.interspace(), body.order());
            assert!(ranks.contains(&4), "no epidural space at {} of {:?}", level.interspace(), body.order());
        }
    }
    assert!(free > 40, "only {free} of 200 interspaces are free");
}

#[test]
fn the_same_numbers_give_the_same_bits_and_others_give_others() {
    let mesh = |order: &BodyOrder| Body::new(order).unwrap().mesh(AnatomyPart::Vertebra(Level::L3), BodyQuality::Low);
    let one = order(3);
    assert_eq!(mesh(&one), mesh(&one));
    assert_ne!(mesh(&one), mesh(&BodyOrder { seed: 4, ..one }));
}

#[test]
fn a_heavier_patient_has_a_deeper_flavum() {
    let depth = |weight_kg: f64| {
        let found = (0..30).filter_map(|seed| {
            let order = BodyOrder { posture: Posture::Sitting, seed, weight_kg, age_years: 40.0 };
            Body::new(&order).unwrap().midline_path(Level::L3, 0.0).to_flavum_m
        });
        let depths: Vec<f64> = found.collect();
        depths.iter().sum::<f64>() / depths.len() as f64
    };
    // 0.18 to 0.37 mm/kg are published.
    let slope = (depth(110.0) - depth(60.0)) * 1e3 / 50.0;
    assert!((0.15..0.40).contains(&slope), "{slope} mm/kg");
}

#[test]
fn a_needle_off_the_midline_meets_muscle_and_a_kidney() {
    let body = Body::new(&BodyOrder { posture: Posture::Prone, seed: 1, weight_kg: 70.0, age_years: 40.0 }).unwrap();
    let kidney = body.mesh(AnatomyPart::Kidney(BodySide::Right), BodyQuality::Low);
    let lowest = kidney.vertices_m.iter().min_by(|a, b| a.y.total_cmp(&b.y)).expect("a kidney");
    let above = nalgebra::Point3::new(lowest.x, lowest.y + 0.015, 0.1);
    let layers = body.list_layers(&above, &-nalgebra::Vector3::z(), 0.3);
    assert_eq!(layers[0].tissue, Tissue::Skin, "{layers:?}");
    assert!(
        layers.iter().any(|layer| layer.tissue == Tissue::Part(AnatomyPart::Kidney(BodySide::Right))),
        "{layers:?}"
    );
}
