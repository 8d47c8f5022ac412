//! Small baked scenes, and a light of three colours.

// Each test binary uses a part of this.
#![allow(dead_code)]

use glam::Vec3;
use ylm::Bands;
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, Mesh, ball, demo};
use ylm_prt::transfer::{
    BakeRecord, BakeSettings, Baked, BounceEnd, Bounces, KeptBounces, TransferKind, bake,
};

pub fn bands(count: usize) -> Bands {
    Bands::new(count).unwrap()
}

fn baked(mesh: &Mesh, bands: Bands, kind: TransferKind) -> Baked {
    let points = LightingPoints::from_mesh(mesh).unwrap();
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let bounces = Bounces { end: BounceEnd::Count(2), kept: KeptBounces::Each, ..Bounces::default() };
    let settings = BakeSettings { bands, kind, rays: 32, bounces, ..BakeSettings::default() };
    let transfer = bake(&points, &bvh, &settings, &()).unwrap();
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    Baked { points, blockers: Blockers::default(), transfer, record }
}

/// A room with a lamp, colours, and light that bounces.
pub fn room(bands: Bands) -> Baked {
    baked(&demo::cornell(), bands, TransferKind::Interreflected)
}

/// Two balls, one in the other's light; their points are no whole number of blocks.
pub fn balls(bands: Bands, kind: TransferKind) -> Baked {
    let mut mesh = ball(Vec3::ZERO, 1.0, 2);
    mesh.append(&ball(Vec3::new(0.8, 1.2, 0.3), 0.4, 2)).unwrap();
    baked(&mesh, bands, kind)
}

pub fn light(bands: Bands) -> LightCoeffs {
    let spec = "disc?dir=1,2,-1&angle=20&color=1,0.5,0.25+sky:clear?sun=35,60+white?intensity=0.2";
    Light::parse(spec).unwrap().project(bands).unwrap()
}
