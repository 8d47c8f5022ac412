//! Balls that stand in the light of a baked scene, on the command line.

use glam::Vec3;
use serde_json::{Value, json};
use ylm_prt::error::Result;
use ylm_prt::light::LightCoeffs;
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, Mesh, ball};
use ylm_prt::shade::{self, Ball, shade_diffuse};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, TransferKind, bake};

use crate::options;

/// How finely a ball is drawn, and stands in the way of the reference's rays: 5120 triangles.
const DIVISIONS: u32 = 4;

/// What a ball looks like.
const ALBEDO: [f32; 3] = [0.5; 3];

/// `--ball` and what goes with it.
#[derive(clap::Args)]
pub struct BallOptions {
    /// A ball that throws its shadow on the scene without a new bake: centre and radius in the model's units; may be given
    /// again
    #[arg(long = "ball", value_parser = parse, value_name = "X,Y,Z,R", allow_hyphen_values = true)]
    balls: Vec<Ball>,
    /// From where a ball is seen to stand in the light
    #[arg(long, value_enum, default_value_t = BallShadow::Vertex)]
    ball_shadow: BallShadow,
}

/// From where a ball is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum BallShadow {
    /// From every vertex: the shadow lies where the ball is
    Vertex,
    /// From the model's middle, once: cheaper, for models that are small beside the ball's distance
    Object,
}

fn parse(text: &str) -> std::result::Result<Ball, String> {
    let wrong = || "must be X,Y,Z,RADIUS with a positive radius, as in 0,1,0.5,0.25".to_owned();
    let values = options::numbers(text).ok_or_else(wrong)?;
    let &[x, y, z, radius] = values.as_slice() else { return Err(wrong()) };
    Ball::new(Vec3::new(x, y, z), radius).map_err(|_| wrong())
}

/// The baked scene with the balls in it, for rays.
pub struct Stage {
    /// The baked points, then those of the balls.
    pub points: LightingPoints,
    /// All triangles.
    pub bvh: Bvh,
    /// The balls alone; none if there are none.
    balls: Option<Baked>,
}

impl BallOptions {
    /// Balls that each vertex sees.
    pub fn of(balls: Vec<Ball>) -> Self {
        Self { balls, ball_shadow: BallShadow::Vertex }
    }

    /// The balls.
    pub fn balls(&self) -> &[Ball] {
        &self.balls
    }

    /// How they shade; `None` without balls.
    pub fn shadow(&self) -> Option<BallShadow> {
        (!self.balls.is_empty()).then_some(self.ball_shadow)
    }

    /// From where they are seen.
    pub fn seen_from(&self) -> shade::BallShadow {
        match self.ball_shadow {
            BallShadow::Vertex => shade::BallShadow::Vertex,
            BallShadow::Object => shade::BallShadow::Object,
        }
    }

    /// The scene and the balls together.
    ///
    /// # Errors
    /// If there are too many points.
    pub fn stage(&self, baked: &Baked) -> Result<Stage> {
        let mut points = LightingPoints {
            positions: baked.points.positions.clone(),
            triangles: baked.points.triangles.clone(),
            ..LightingPoints::default()
        };
        let balls = self.bake(baked)?;
        if let Some(balls) = &balls {
            let first = points.positions.len() as u32;
            points.positions.extend(&balls.points.positions);
            points
                .triangles
                .extend(balls.points.triangles.iter().map(|corners| corners.map(|corner| corner + first)));
        }
        let bvh = Bvh::build(&points.positions, &points.triangles);
        Ok(Stage { points, bvh, balls })
    }

    /// What rays of the reference meet: the balls, and all that blocked in the bake.
    ///
    /// # Errors
    /// If there are too many vertices.
    pub fn blockers(&self, baked: &Baked) -> Result<Bvh> {
        let mut blockers = match baked.record.kind {
            TransferKind::Unshadowed => Blockers::default(),
            _ => baked.blockers.clone(),
        };
        for one in &self.balls {
            blockers.add(&ball(one.center(), one.radius(), DIVISIONS))?;
        }
        blockers.check_beside(&baked.points)?;
        Ok(match baked.record.kind {
            TransferKind::Unshadowed => Bvh::build(&blockers.positions, &blockers.triangles),
            _ => Bvh::of_scene(&baked.points, &blockers),
        })
    }

    /// The balls by themselves: what they look like.
    fn bake(&self, baked: &Baked) -> Result<Option<Baked>> {
        let mut mesh = Mesh::default();
        for one in &self.balls {
            mesh.append(&ball(one.center(), one.radius(), DIVISIONS))?;
        }
        if mesh.triangles.is_empty() {
            return Ok(None);
        }
        mesh.paint(ALBEDO);
        let points = LightingPoints::from_mesh(&mesh)?;
        let settings = BakeSettings {
            bands: baked.transfer.bands,
            kind: TransferKind::Unshadowed,
            rays: 0,
            seed: 0,
            bias: BakeSettings::BIAS,
            t_max: f32::INFINITY,
            ..BakeSettings::default()
        };
        let transfer = bake(&points, &Bvh::build(&[], &[]), &settings, &())?;
        let record = BakeRecord::new(&settings, Vec::new(), String::new());
        Ok(Some(Baked { points, blockers: Blockers::default(), transfer, record }))
    }

    /// For `--json`: each ball, and how they shade; null without balls.
    pub fn json(&self) -> Value {
        let Some(shadow) = self.shadow() else { return Value::Null };
        let balls: Vec<Value> = (self.balls.iter())
            .map(|ball| json!({ "center": ball.center().to_array(), "radius": ball.radius() }))
            .collect();
        json!({ "shadow": format!("{shadow:?}").to_lowercase(), "balls": balls })
    }
}

impl Stage {
    /// The radiance of the balls' points, which are drawn lit but not shadowed.
    pub fn light_balls(&self, light: &LightCoeffs) -> Vec<Vec3> {
        self.balls.as_ref().map_or_else(Vec::new, |balls| shade_diffuse(balls, light))
    }
}
