//! Typed elements out of buffers.

use glam::DVec3;
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::{Root, validation::Checked};

use crate::scene::gltf::buffer::Buffers;
use crate::scene::gltf::{GltfFault, get};

/// The accessors of a file and the bytes they name.
pub(super) struct Accessors<'a> {
    pub root: &'a Root,
    pub buffers: &'a Buffers<'a>,
    /// The bytes of the file and its buffers.
    pub byte_count: usize,
}

/// The elements of one accessor, packed, with sparse values in place.
struct Elements {
    bytes: Vec<u8>,
    component: ComponentType,
    is_normalized: bool,
}

impl Accessors<'_> {
    /// The number of elements.
    pub fn count(&self, accessor: usize) -> Result<usize, GltfFault> {
        let count = get(&self.root.accessors, accessor, "accessor")?.count.0;
        usize::try_from(count).map_err(|_| GltfFault::AccessorWithoutData { accessor })
    }

    /// Sees to it that an attribute has as many elements as the positions.
    pub fn check_count(&self, accessor: usize, positions: usize) -> Result<(), GltfFault> {
        match self.count(accessor)? {
            count if count == positions => Ok(()),
            count => Err(GltfFault::AttributeCount { accessor, count, positions }),
        }
    }

    /// Positions: floats, or with KHR_mesh_quantization integers.
    pub fn positions(&self, accessor: usize) -> Result<Vec<DVec3>, GltfFault> {
        let expected = "positions are VEC3 of floats, or with KHR_mesh_quantization of 8 or 16 bits";
        let elements = self.elements(accessor, &[Type::Vec3], expected)?;
        if elements.component == ComponentType::U32 {
            return Err(GltfFault::AccessorType { accessor, expected });
        }
        Ok(elements.numbers().as_chunks().0.iter().map(|&v| DVec3::from_array(v)).collect())
    }

    /// Normals: floats, or with KHR_mesh_quantization normalised signed integers.
    pub fn normals(&self, accessor: usize) -> Result<Vec<DVec3>, GltfFault> {
        let expected = "normals are VEC3 of floats, or of normalized signed 8 or 16 bits";
        let elements = self.elements(accessor, &[Type::Vec3], expected)?;
        match (elements.component, elements.is_normalized) {
            (ComponentType::F32, _) | (ComponentType::I8 | ComponentType::I16, true) => {}
            _ => return Err(GltfFault::AccessorType { accessor, expected }),
        }
        Ok(elements.numbers().as_chunks().0.iter().map(|&v| DVec3::from_array(v)).collect())
    }

    /// Linear colours without their alpha: floats or normalised unsigned integers.
    pub fn colours(&self, accessor: usize) -> Result<Vec<[f32; 3]>, GltfFault> {
        let expected = "colours are VEC3 or VEC4 of floats or of normalized unsigned 8 or 16 bits";
        let elements = self.elements(accessor, &[Type::Vec3, Type::Vec4], expected)?;
        match (elements.component, elements.is_normalized) {
            (ComponentType::F32, _) | (ComponentType::U8 | ComponentType::U16, true) => {}
            _ => return Err(GltfFault::AccessorType { accessor, expected }),
        }
        let numbers = elements.numbers();
        let width = if self.root.accessors[accessor].type_ == Checked::Valid(Type::Vec3) { 3 } else { 4 };
        Ok(numbers.chunks_exact(width).map(|c| [c[0] as f32, c[1] as f32, c[2] as f32]).collect())
    }

    /// Texture coordinates: floats or normalised unsigned integers.
    pub fn texture_coordinates(&self, accessor: usize) -> Result<Vec<[f64; 2]>, GltfFault> {
        let expected = "texture coordinates are VEC2 of floats or of normalized unsigned 8 or 16 bits";
        let elements = self.elements(accessor, &[Type::Vec2], expected)?;
        match (elements.component, elements.is_normalized) {
            (ComponentType::F32, _) | (ComponentType::U8 | ComponentType::U16, true) => {}
            _ => return Err(GltfFault::AccessorType { accessor, expected }),
        }
        Ok(elements.numbers().as_chunks().0.to_vec())
    }

    /// Indices: unsigned integers.
    pub fn indices(&self, accessor: usize) -> Result<Vec<u32>, GltfFault> {
        let expected = "indices are SCALAR of unsigned integers";
        let elements = self.elements(accessor, &[Type::Scalar], expected)?;
        if elements.is_normalized {
            return Err(GltfFault::AccessorType { accessor, expected });
        }
        integers(&elements.bytes, elements.component).ok_or(GltfFault::AccessorType { accessor, expected })
    }

    fn elements(&self, index: usize, types: &[Type], expected: &'static str) -> Result<Elements, GltfFault> {
        let accessor = get(&self.root.accessors, index, "accessor")?;
        let (Checked::Valid(type_), Checked::Valid(component)) = (accessor.type_, accessor.component_type)
        else {
            return Err(GltfFault::AccessorType { accessor: index, expected });
        };
        let component = component.0;
        let width = match type_ {
            Type::Scalar => 1,
            Type::Vec2 => 2,
            Type::Vec3 => 3,
            _ => 4,
        };
        if !types.contains(&type_) {
            return Err(GltfFault::AccessorType { accessor: index, expected });
        }
        let size = width * component.size();
        let count = self.count(index)?;
        let mut bytes = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                self.gather(index, view.value(), offset, count, size)?
            }
            // Zeros that no byte stands for, but no more of them than the file has bytes.
            None if accessor.sparse.is_some() && count <= self.byte_count => vec![0; count * size],
            None => return Err(GltfFault::AccessorWithoutData { accessor: index }),
        };
        self.apply_sparse(index, accessor, size, &mut bytes)?;
        Ok(Elements { bytes, component, is_normalized: accessor.normalized })
    }

    /// Puts the sparse values of an accessor in place.
    fn apply_sparse(
        &self,
        index: usize,
        accessor: &Accessor,
        size: usize,
        bytes: &mut [u8],
    ) -> Result<(), GltfFault> {
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        let type_fault =
            GltfFault::AccessorType { accessor: index, expected: "sparse indices are unsigned integers" };
        let Checked::Valid(component) = sparse.indices.component_type else { return Err(type_fault) };
        let component = component.0;
        let places = &sparse.indices;
        let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        let view = places.buffer_view.value();
        let places = self.gather(index, view, places.byte_offset.0, count, component.size())?;
        let places = integers(&places, component).ok_or(type_fault)?;
        let values = &sparse.values;
        let values = self.gather(index, values.buffer_view.value(), values.byte_offset.0, count, size)?;
        let mut next = 0;
        for (&place, value) in places.iter().zip(values.chunks_exact(size)) {
            let fault = GltfFault::SparseIndex { accessor: index, index: place };
            if (place as usize) < next {
                return Err(fault);
            }
            next = place as usize + 1;
            bytes.chunks_exact_mut(size).nth(place as usize).ok_or(fault)?.copy_from_slice(value);
        }
        Ok(())
    }

    /// The bytes of a buffer view.
    pub fn view(&self, view_index: usize) -> Result<&[u8], GltfFault> {
        let view = get(&self.root.buffer_views, view_index, "buffer view")?;
        let buffer_index = view.buffer.value();
        let buffer = self.buffers.get(buffer_index)?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.saturating_add(view.byte_length.0);
        if end > buffer.len() as u64 {
            let length = buffer.len() as u64;
            return Err(GltfFault::ViewRange { view: view_index, end, buffer: buffer_index, length });
        }
        Ok(&buffer[start as usize..end as usize])
    }

    /// The bytes of `count` elements of `size` bytes each, from byte `offset` of a buffer view, packed.
    fn gather(
        &self,
        accessor: usize,
        view_index: usize,
        offset: u64,
        count: usize,
        size: usize,
    ) -> Result<Vec<u8>, GltfFault> {
        let bytes = self.view(view_index)?;
        let view = &self.root.buffer_views[view_index];
        let stride = view.byte_stride.map_or(size, |stride| stride.0);
        let is_suitable = stride >= size
            && (view.byte_stride.is_none() || (4..=252).contains(&stride) && stride.is_multiple_of(4));
        if !is_suitable {
            return Err(GltfFault::Stride { view: view_index, stride, accessor });
        }
        if count == 0 {
            return Ok(Vec::new());
        }
        let last = (count as u64 - 1).saturating_mul(stride as u64).saturating_add(offset);
        let end = last.saturating_add(size as u64);
        if end > bytes.len() as u64 {
            return Err(GltfFault::AccessorRange { accessor, end, view: view_index, length: bytes.len() });
        }
        let elements = bytes[offset as usize..end as usize].chunks(stride);
        Ok(elements.flat_map(|element| &element[..size]).copied().collect())
    }
}

impl Elements {
    /// All components as numbers; normalised integers within −1 to 1.
    fn numbers(&self) -> Vec<f64> {
        let bytes = self.bytes.as_slice();
        let scaled =
            |value: f64, largest: f64| if self.is_normalized { (value / largest).max(-1.0) } else { value };
        match self.component {
            ComponentType::I8 => bytes.iter().map(|&b| scaled(f64::from(b.cast_signed()), 127.0)).collect(),
            ComponentType::U8 => bytes.iter().map(|&b| scaled(f64::from(b), 255.0)).collect(),
            ComponentType::I16 => {
                let numbers = bytes.as_chunks().0.iter().map(|&b| f64::from(i16::from_le_bytes(b)));
                numbers.map(|value| scaled(value, 32767.0)).collect()
            }
            ComponentType::U16 => {
                let numbers = bytes.as_chunks().0.iter().map(|&b| f64::from(u16::from_le_bytes(b)));
                numbers.map(|value| scaled(value, 65535.0)).collect()
            }
            ComponentType::U32 => {
                bytes.as_chunks().0.iter().map(|&b| f64::from(u32::from_le_bytes(b))).collect()
            }
            ComponentType::F32 => {
                bytes.as_chunks().0.iter().map(|&b| f64::from(f32::from_le_bytes(b))).collect()
            }
        }
    }
}

/// Unsigned integers; `None` for other types.
fn integers(bytes: &[u8], component: ComponentType) -> Option<Vec<u32>> {
    match component {
        ComponentType::U8 => Some(bytes.iter().map(|&b| u32::from(b)).collect()),
        ComponentType::U16 => {
            Some(bytes.as_chunks().0.iter().map(|&b| u32::from(u16::from_le_bytes(b))).collect())
        }
        ComponentType::U32 => Some(bytes.as_chunks().0.iter().map(|&b| u32::from_le_bytes(b)).collect()),
        _ => None,
    }
}
