//! Reads glTF 2.0, as JSON or binary (GLB). [Khronos 2021] "glTF 2.0 Specification"
//!
//! The crate gltf gives the types of the JSON; containers, buffers and accessors are read here, with every offset
//! checked: the crate's own readers underflow on short GLB headers and unwrap on short sparse data.

mod accessor;
mod buffer;
mod fault;
mod material;

use std::collections::HashMap;
use std::path::Path;

use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::json::{self, Index, Root, mesh::Mode, mesh::Semantic, validation::Checked};

use crate::scene::draft::{Corner, Draft};
use crate::scene::read::{AlbedoSource, Place, excerpt};
use accessor::Accessors;
use buffer::Buffers;
use material::Painter;

pub use fault::GltfFault;

/// Required extensions that change nothing about positions, normals and base colours.
const HARMLESS_EXTENSIONS: [&str; 8] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_mesh_quantization",
    "KHR_xmp",
];

/// Vertices and corners that nodes may add up to, whatever the file's length: scenes repeat their meshes.
const MIN_INSTANCE_BUDGET: usize = 1 << 22;

/// Vertices and corners that nodes may add up to for each byte of the file and its buffers, if that is more.
const INSTANCE_BUDGET_PER_BYTE: usize = 4;

/// Reads the default scene, else the first, else all nodes.
///
/// Albedo is baseColorFactor times baseColorTexture times COLOR_0, emission emissiveFactor times emissiveTexture times
/// emissiveStrength, both at vertices. Points and lines are passed over. `folder` is where the files of buffers and
/// images lie.
pub(crate) fn read(bytes: &[u8], folder: &Path, albedo: AlbedoSource) -> Result<Draft, GltfFault> {
    let (text, blob) = buffer::split_container(bytes)?;
    let root: Root =
        json::deserialize::from_slice(text).map_err(|error| GltfFault::Json { reason: error.to_string() })?;
    if root.asset.version.split('.').next() != Some("2") {
        return Err(GltfFault::Version { version: excerpt(root.asset.version.as_bytes()) });
    }
    let harmless = |name: &String| HARMLESS_EXTENSIONS.iter().any(|harmless| name.starts_with(harmless));
    // Of several, compression is the one that says why.
    let mut refused: Vec<&String> = root.extensions_required.iter().filter(|name| !harmless(name)).collect();
    refused.sort_by_key(|name| !name.contains("compression"));
    if let Some(name) = refused.first() {
        return Err(GltfFault::Extension { name: excerpt(name.as_bytes()) });
    }
    let buffers = Buffers::load(&root, blob, folder)?;
    let byte_count = bytes.len().saturating_add(buffers.byte_count);
    // Below the range of indices in any case.
    let max = byte_count
        .saturating_mul(INSTANCE_BUDGET_PER_BYTE)
        .max(MIN_INSTANCE_BUDGET)
        .min(u32::MAX as usize - 1);
    let accessors = Accessors { root: &root, buffers: &buffers, byte_count };
    let painter = Painter::new(albedo);
    let mut scene = Scene { accessors, draft: Draft::default(), painter, budget: max, max };
    for (node, world_from_local) in placed_nodes(&root)? {
        scene.add_node(node, world_from_local)?;
    }
    let Scene { accessors, mut draft, painter, .. } = scene;
    painter.finish(&accessors, folder, &mut draft)?;
    Ok(draft)
}

/// The item that an index names.
fn get<'a, T>(items: &'a [T], index: usize, of: &'static str) -> Result<&'a T, GltfFault> {
    items.get(index).ok_or(GltfFault::Missing { of, index, count: items.len() })
}

/// The nodes of the scene that have a mesh, with their transforms, parents before children.
///
/// No recursion: nodes may nest as deep as they like.
fn placed_nodes(root: &Root) -> Result<Vec<(usize, DMat4)>, GltfFault> {
    let roots: Vec<usize> = match (root.scene, root.scenes.first()) {
        (Some(scene), _) => {
            get(&root.scenes, scene.value(), "scene")?.nodes.iter().map(Index::value).collect()
        }
        (None, Some(scene)) => scene.nodes.iter().map(Index::value).collect(),
        (None, None) => {
            let mut is_child = vec![false; root.nodes.len()];
            for child in root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten() {
                if let Some(is_child) = is_child.get_mut(child.value()) {
                    *is_child = true;
                }
            }
            (0..root.nodes.len()).filter(|&node| !is_child[node]).collect()
        }
    };
    let mut placed = Vec::new();
    let mut reached = vec![false; root.nodes.len()];
    let mut open: Vec<(usize, DMat4)> = roots.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((index, world_from_parent)) = open.pop() {
        let node = get(&root.nodes, index, "node")?;
        if std::mem::replace(&mut reached[index], true) {
            return Err(GltfFault::NodeTwice { node: index });
        }
        let world_from_local = world_from_parent * parent_from_local(node, index)?;
        if node.mesh.is_some() {
            placed.push((index, world_from_local));
        }
        let children = node.children.iter().flatten();
        open.extend(children.rev().map(|child| (child.value(), world_from_local)));
    }
    Ok(placed)
}

fn parent_from_local(node: &json::Node, index: usize) -> Result<DMat4, GltfFault> {
    if let Some(matrix) = node.matrix {
        return Ok(DMat4::from_cols_array(&matrix.map(f64::from)));
    }
    let rotation = node.rotation.unwrap_or_default().0;
    let quaternion = DQuat::from_array(rotation.map(f64::from));
    // Exporters round to single precision or to bytes (1/127); what is farther off is no rounding.
    let is_unit = (quaternion.length() - 1.0).abs() <= 0.01;
    if !is_unit {
        return Err(GltfFault::Rotation { node: index, rotation });
    }
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    Ok(DMat4::from_scale_rotation_translation(
        vector(node.scale.unwrap_or([1.0; 3])),
        quaternion.normalize(),
        vector(node.translation.unwrap_or([0.0; 3])),
    ))
}

/// What the nodes add up to.
struct Scene<'a> {
    accessors: Accessors<'a>,
    draft: Draft,
    painter: Painter,
    /// Vertices and corners that may still be added.
    budget: usize,
    max: usize,
}

/// Vertices that primitives of one node share: their positions and normals.
type VertexKey = (usize, Option<usize>);

impl Scene<'_> {
    fn spend(&mut self, count: usize) -> Result<(), GltfFault> {
        self.budget = self.budget.checked_sub(count).ok_or(GltfFault::TooManyInstances { max: self.max })?;
        Ok(())
    }

    fn add_node(&mut self, node_index: usize, world_from_local: DMat4) -> Result<(), GltfFault> {
        let root = self.accessors.root;
        let node = &root.nodes[node_index];
        let Some(mesh_index) = node.mesh.map(|mesh| mesh.value()) else { return Ok(()) };
        let mesh = get(&root.meshes, mesh_index, "mesh")?;
        if node.skin.is_some() {
            return Err(GltfFault::Skin { node: node_index });
        }
        let weights = node.weights.as_ref().or(mesh.weights.as_ref());
        if weights.is_some_and(|weights| weights.iter().any(|&weight| weight != 0.0)) {
            return Err(GltfFault::Morph { mesh: mesh_index });
        }
        let mut vertices = HashMap::new();
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            let at = PrimitivePlace { mesh: mesh_index, primitive: index };
            self.add_primitive(primitive, at, world_from_local, &mut vertices)?;
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        primitive: &json::mesh::Primitive,
        at: PrimitivePlace,
        world_from_local: DMat4,
        vertices: &mut HashMap<VertexKey, Vertices>,
    ) -> Result<(), GltfFault> {
        let PrimitivePlace { mesh, primitive: index } = at;
        let mode = match primitive.mode {
            Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) => return Ok(()),
            Checked::Valid(mode) => mode,
            Checked::Invalid => return Err(GltfFault::Mode { mesh, primitive: index }),
        };
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(Index::value);
        let positions =
            attribute(Semantic::Positions).ok_or(GltfFault::NoPosition { mesh, primitive: index })?;
        let normals = attribute(Semantic::Normals);
        let colours = attribute(Semantic::Colors(0));
        let coordinates = |set| attribute(Semantic::TexCoords(set));
        let look = self.painter.look(&self.accessors, primitive.material, colours, coordinates, at)?;
        let shared = match vertices.get(&(positions, normals)) {
            Some(&shared) => shared,
            None => {
                let added = self.add_vertices(positions, normals, world_from_local)?;
                vertices.insert((positions, normals), added);
                added
            }
        };
        let first = shared.first_position as usize;
        let place = Place::Accessor { accessor: positions, element: 0 };
        let materials = match self.painter.materials(&look, first) {
            Some(materials) => materials,
            None => {
                if !look.is_uniform() {
                    self.spend(shared.count)?;
                }
                self.painter.add(&self.accessors, &look, first, shared.count, place, &mut self.draft)?
            }
        };
        let corners: Vec<u32> = match primitive.indices {
            Some(indices) => {
                self.spend(self.accessors.count(indices.value())?)?;
                self.accessors.indices(indices.value())?
            }
            None => {
                self.spend(shared.count)?;
                (0..shared.count as u32).collect()
            }
        };
        if let Some(element) = corners.iter().position(|&corner| corner as usize >= shared.count) {
            let accessor = primitive.indices.map_or(0, |indices| indices.value());
            let at = Place::Accessor { accessor, element };
            return Err(GltfFault::VertexIndex { at, index: corners[element], count: shared.count });
        }
        let is_even = match mode {
            Mode::Triangles => corners.len().is_multiple_of(3),
            _ => corners.len() >= 3,
        };
        if !is_even {
            return Err(GltfFault::CornerCount { mesh, primitive: index, count: corners.len() });
        }
        let triangle_count = if mode == Mode::Triangles { corners.len() / 3 } else { corners.len() - 2 };
        // A transform that mirrors turns triangles inside out, unless they wind the other way.
        let is_mirrored = world_from_local.determinant() < 0.0;
        for k in 0..triangle_count {
            let [a, b, c] = match mode {
                Mode::Triangles => [3 * k, 3 * k + 1, 3 * k + 2],
                // (1 + k % 2) and its counterpart alternate the winding along the strip.
                Mode::TriangleStrip => [k, k + 1 + k % 2, k + 2 - k % 2],
                _ => [k + 1, k + 2, 0],
            }
            .map(|corner| corners[corner]);
            let is_stitch = mode != Mode::Triangles && (a == b || b == c || c == a);
            if !is_stitch {
                let triangle = if is_mirrored { [a, c, b] } else { [a, b, c] };
                self.draft.add_face(
                    triangle.map(|corner| Corner {
                        material: materials.of_vertex(corner),
                        ..shared.corner(corner)
                    }),
                );
            }
        }
        Ok(())
    }

    /// Adds the vertices of a primitive.
    fn add_vertices(
        &mut self,
        positions: usize,
        normals: Option<usize>,
        world_from_local: DMat4,
    ) -> Result<Vertices, GltfFault> {
        let count = self.accessors.count(positions)?;
        self.spend(count)?;
        if let Some(accessor) = normals {
            self.accessors.check_count(accessor, count)?;
        }
        let first_position = self.draft.position_count() as u32;
        let first_normal = normals.map(|_| self.draft.normal_count() as u32);
        for (element, position) in self.accessors.positions(positions)?.into_iter().enumerate() {
            let at = Place::Accessor { accessor: positions, element };
            self.draft.add_position(world_from_local.transform_point3(position), at);
        }
        if let Some(accessor) = normals {
            let world_from_normal = world_from_normal(world_from_local);
            for normal in self.accessors.normals(accessor)? {
                self.draft.add_normal(world_from_normal * normal);
            }
        }
        Ok(Vertices { first_position, first_normal, count })
    }
}

/// Which primitive, for faults.
#[derive(Clone, Copy)]
struct PrimitivePlace {
    mesh: usize,
    primitive: usize,
}

/// Where the vertices of a primitive stand in the draft.
#[derive(Clone, Copy)]
struct Vertices {
    first_position: u32,
    first_normal: Option<u32>,
    count: usize,
}

impl Vertices {
    fn corner(&self, index: u32) -> Corner {
        let normal = self.first_normal.map_or(Corner::NONE, |first| first + index);
        Corner { position: self.first_position + index, normal, material: Corner::NONE }
    }
}

/// The inverse transpose of a transform's linear part, up to a positive factor, which normals do not need.
///
/// The matrix of cofactors is det · inverse transpose; it exists where the inverse does not.
fn world_from_normal(world_from_local: DMat4) -> DMat3 {
    let linear = DMat3::from_mat4(world_from_local);
    let cofactors = DMat3::from_cols(
        linear.y_axis.cross(linear.z_axis),
        linear.z_axis.cross(linear.x_axis),
        linear.x_axis.cross(linear.y_axis),
    );
    if linear.determinant() < 0.0 { -cofactors } else { cofactors }
}
