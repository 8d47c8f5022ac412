//! Materials of primitives: what a vertex reflects and sends out, looked up in textures at its coordinates.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use gltf::json::texture::{Info, MagFilter, WrappingMode};
use gltf::json::{self, Index, validation::Checked};

use crate::scene::beside::read_file;
use crate::scene::draft::{Corner, Draft};
use crate::scene::gltf::accessor::Accessors;
use crate::scene::gltf::buffer::{Uri, UriFault};
use crate::scene::gltf::{GltfFault, PrimitivePlace, get};
use crate::scene::mesh::Material;
use crate::scene::read::{AlbedoSource, Place, excerpt};
use crate::scene::texture::{Filter, Sampler, Texture, Wrap};

/// What decides the materials of a primitive's vertices.
pub(super) struct Look {
    material: Option<usize>,
    /// What textures and colours are multiplied with.
    factor: Material,
    /// Accessor of COLOR_0.
    colours: Option<usize>,
    albedo: Option<TextureUse>,
    emission: Option<TextureUse>,
}

/// A texture with the accessor of its coordinates and their transform.
#[derive(Clone, Copy)]
struct TextureUse {
    texture: usize,
    coordinates: usize,
    /// u' = a u + b v + c, and the same for v'.
    transform: [[f64; 3]; 2],
}

impl Look {
    /// Whether all vertices have one material.
    pub fn is_uniform(&self) -> bool {
        self.colours.is_none() && self.albedo.is_none() && self.emission.is_none()
    }

    /// What tells looks of the same vertices apart.
    fn key(&self) -> LookKey {
        let coordinates =
            |texture_use: Option<TextureUse>| texture_use.map(|texture_use| texture_use.coordinates);
        [self.material, self.colours, coordinates(self.albedo), coordinates(self.emission)]
    }
}

/// The material and the accessors of colours and texture coordinates.
type LookKey = [Option<usize>; 4];

/// Materials in the draft.
#[derive(Clone, Copy, Debug)]
pub(super) enum Painted {
    /// One for all vertices; [`Corner::NONE`] for white.
    All(u32),
    /// One for each, from this.
    EachFrom(u32),
}

impl Painted {
    pub fn of_vertex(self, vertex: u32) -> u32 {
        match self {
            Self::All(material) => material,
            Self::EachFrom(first) => first + vertex,
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Channel {
    Albedo,
    Emission,
}

/// Vertices that await a texture.
struct Waiting {
    channel: Channel,
    first_material: u32,
    /// Texture coordinates of one vertex after the other.
    coordinates: Vec<[f64; 2]>,
}

/// Gives vertices their materials: factors and colours at once, textures at the end, one picture at a time.
pub(super) struct Painter {
    albedo: AlbedoSource,
    /// What was added, by the first position of the vertices.
    added: HashMap<(usize, LookKey), Painted>,
    waiting: BTreeMap<usize, Vec<Waiting>>,
}

impl Painter {
    pub fn new(albedo: AlbedoSource) -> Self {
        Self { albedo, added: HashMap::new(), waiting: BTreeMap::new() }
    }

    /// What a primitive looks like; `coordinates` gives the accessor of a set of texture coordinates.
    pub fn look(
        &self,
        accessors: &Accessors,
        material: Option<Index<json::Material>>,
        colours: Option<usize>,
        coordinates: impl Fn(u32) -> Option<usize>,
        at: PrimitivePlace,
    ) -> Result<Look, GltfFault> {
        let is_albedo_read = self.albedo == AlbedoSource::File;
        let colours = colours.filter(|_| is_albedo_read);
        let Some(index) = material else {
            return Ok(Look {
                material: None,
                factor: Material::WHITE,
                colours,
                albedo: None,
                emission: None,
            });
        };
        let material = get(&accessors.root.materials, index.value(), "material")?;
        let texture_use = |info: &Option<Info>| {
            let Some(info) = info else { return Ok(None) };
            let transform =
                info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
            let set = transform.and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord);
            let PrimitivePlace { mesh, primitive } = at;
            let coordinates =
                coordinates(set).ok_or(GltfFault::NoTextureCoordinates { mesh, primitive, set })?;
            let transform = transform.map_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], |transform| {
                // Translation · rotation · scale, the rotation as [KHR_texture_transform] has it.
                let (sin, cos) = f64::from(transform.rotation.0).sin_cos();
                let [sx, sy] = transform.scale.0.map(f64::from);
                let [x, y] = transform.offset.0.map(f64::from);
                [[cos * sx, sin * sy, x], [-sin * sx, cos * sy, y]]
            });
            Ok(Some(TextureUse { texture: info.index.value(), coordinates, transform }))
        };
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, _] = pbr.base_color_factor.0;
        let strength =
            material.extensions.as_ref().and_then(|extensions| extensions.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
        let emission = material.emissive_factor.0.map(|factor| factor * strength);
        if !emission.iter().all(|value| value.is_finite() && *value >= 0.0) {
            return Err(GltfFault::Emission { material: index.value(), emission });
        }
        let albedo = if is_albedo_read { [r, g, b] } else { Material::WHITE.albedo };
        Ok(Look {
            material: Some(index.value()),
            factor: Material { albedo, emission },
            colours,
            albedo: if is_albedo_read { texture_use(&pbr.base_color_texture)? } else { None },
            // Most materials have a texture of emission and a factor of 0.
            emission: if emission == [0.0; 3] { None } else { texture_use(&material.emissive_texture)? },
        })
    }

    /// The materials of the vertices from the position `first`, if they were added.
    pub fn materials(&self, look: &Look, first: usize) -> Option<Painted> {
        self.added.get(&(first, look.key())).copied()
    }

    /// Adds the materials of `count` vertices from the position `first`.
    pub fn add(
        &mut self,
        accessors: &Accessors,
        look: &Look,
        first: usize,
        count: usize,
        at: Place,
        draft: &mut Draft,
    ) -> Result<Painted, GltfFault> {
        let Material { albedo: [r, g, b], emission } = look.factor;
        let mut add = |[x, y, z]: [f32; 3], at: Place| {
            let index = draft.add_colour([r * x, g * y, b * z], at);
            draft.material_mut(index).emission = emission;
            index
        };
        let painted = if look.is_uniform() {
            let is_white = look.factor == Material::WHITE;
            Painted::All(if is_white { Corner::NONE } else { add([1.0; 3], at) })
        } else {
            let colours = match look.colours {
                Some(accessor) => {
                    accessors.check_count(accessor, count)?;
                    Some(accessors.colours(accessor)?)
                }
                None => None,
            };
            let mut first_material = 0;
            for element in 0..count {
                let at = match at {
                    Place::Accessor { accessor, .. } => Place::Accessor { accessor, element },
                    other => other,
                };
                let index = add(colours.as_ref().map_or([1.0; 3], |colours| colours[element]), at);
                if element == 0 {
                    first_material = index;
                }
            }
            let uses = [(Channel::Albedo, look.albedo), (Channel::Emission, look.emission)];
            for (channel, texture_use) in uses {
                let Some(TextureUse { texture, coordinates, transform }) = texture_use else { continue };
                accessors.check_count(coordinates, count)?;
                let coordinates = accessors.texture_coordinates(coordinates)?;
                let transformed =
                    coordinates.iter().map(|[u, v]| transform.map(|[a, b, c]| a * u + b * v + c));
                let waiting = Waiting { channel, first_material, coordinates: transformed.collect() };
                self.waiting.entry(texture).or_default().push(waiting);
            }
            Painted::EachFrom(first_material)
        };
        self.added.insert((first, look.key()), painted);
        Ok(painted)
    }

    /// Looks up what awaits its texture.
    pub fn finish(self, accessors: &Accessors, folder: &Path, draft: &mut Draft) -> Result<(), GltfFault> {
        // By picture, so that each is decoded once and no two are held.
        let mut by_image: BTreeMap<usize, Vec<(Sampler, Vec<Waiting>)>> = BTreeMap::new();
        for (index, waiting) in self.waiting {
            let texture = get(&accessors.root.textures, index, "texture")?;
            let sampler = sampler(accessors.root, texture)?;
            if texture.source.value() == u32::MAX as usize {
                return Err(GltfFault::TextureWithoutImage { texture: index });
            }
            by_image.entry(texture.source.value()).or_default().push((sampler, waiting));
        }
        for (image, users) in by_image {
            let texture = load(accessors, image, folder)?;
            for (sampler, waiting) in users {
                for Waiting { channel, first_material, coordinates } in waiting {
                    for (material, coordinates) in (first_material..).zip(coordinates) {
                        let value = texture.sample(coordinates, &sampler);
                        let material = draft.material_mut(material);
                        let channels = match channel {
                            Channel::Albedo => &mut material.albedo,
                            Channel::Emission => &mut material.emission,
                        };
                        channels.iter_mut().zip(value).for_each(|(channel, value)| *channel *= value);
                    }
                }
            }
        }
        Ok(())
    }
}

fn sampler(root: &json::Root, texture: &json::Texture) -> Result<Sampler, GltfFault> {
    let Some(index) = texture.sampler else { return Ok(Sampler::default()) };
    let sampler = get(&root.samplers, index.value(), "sampler")?;
    let wrap = |mode: Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    };
    let filter = match sampler.mag_filter {
        Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
        _ => Filter::Linear,
    };
    Ok(Sampler { wrap: [wrap(sampler.wrap_s), wrap(sampler.wrap_t)], filter })
}

/// Reads and decodes an image, from a file, a data URI or a buffer view.
fn load(accessors: &Accessors, index: usize, folder: &Path) -> Result<Texture, GltfFault> {
    let image = get(&accessors.root.images, index, "image")?;
    let is_data = |uri: &&String| !uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"));
    let name = image.uri.as_ref().filter(is_data).map_or(String::new(), |uri| excerpt(uri.as_bytes()));
    let fault = |reason: String| GltfFault::Image { image: index, name: name.clone(), reason };
    let decode = |bytes: &[u8]| Texture::decode(bytes).map_err(|error| fault(error.to_string()));
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => match Uri::parse(uri, folder) {
            Ok(Uri::Data(data)) => decode(&data),
            Ok(Uri::File(path)) => decode(&read_file(&path).map_err(fault)?),
            Err(UriFault::Outside) => {
                Err(fault("leaves the folder of the file; only files beside or below it are read".to_owned()))
            }
            Err(UriFault::Data(reason)) => Err(fault(format!("its data URI cannot be decoded: {reason}"))),
        },
        (None, Some(view)) => decode(accessors.view(view.value())?),
        (None, None) => Err(fault("has no data".to_owned())),
    }
}
