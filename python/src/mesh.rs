//! Meshes: read, or made of arrays.

use std::path::PathBuf;

use glam::Vec3;
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use ylm_prt::scene::{AlbedoSource, Material, Materials, NonFinite, Normals, ReadOptions, UpAxis, demo};

use crate::arrays::{Array, array_of, float_array, rows, wrong_shape};
use crate::error::raise;

/// Triangles over shared positions.
#[pyclass(frozen, module = "ylm._native")]
pub struct Mesh(pub ylm_prt::scene::Mesh);

#[pymethods]
impl Mesh {
    /// Positions [p, 3], triangles [t, 3], and one normal [p, 3] and material [p, 3] a position.
    #[new]
    fn new(
        positions: &Bound<'_, PyAny>,
        triangles: PyReadonlyArray2<'_, u32>,
        normals: Option<&Bound<'_, PyAny>>,
        albedo: Option<&Bound<'_, PyAny>>,
        emission: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let positions = vectors("positions", positions, None)?;
        let count = positions.len();
        let [_, 3] = *triangles.shape() else {
            return Err(wrong_shape("triangles", triangles.shape(), "(t, 3)"));
        };
        let triangles: Vec<[u32; 3]> = triangles.as_slice()?.as_chunks().0.to_vec();
        if let Some(index) = triangles.as_flattened().iter().find(|index| **index as usize >= count) {
            let message = format!("triangles name position {index}; there are {count}");
            return Err(PyValueError::new_err(message));
        }
        let normals = normals.map(|normals| vectors("normals", normals, Some(count))).transpose()?;
        let normals = normals
            .map(|vectors| {
                let unit: Option<Vec<Vec3>> = vectors.iter().map(|normal| normal.try_normalize()).collect();
                let vectors = unit.ok_or_else(|| PyValueError::new_err("a normal is zero"))?;
                Ok::<_, PyErr>(Normals { vectors, triangles: triangles.clone() })
            })
            .transpose()?;
        let materials = materials(albedo, emission, count)?
            .map(|values| Materials { values, triangles: triangles.clone() });
        Ok(Self(ylm_prt::scene::Mesh { positions, triangles, normals, materials }))
    }

    /// Reads a file: the mesh, and sentences about what is not as the file has it.
    #[staticmethod]
    fn open(
        py: Python<'_>,
        path: PathBuf,
        up: &str,
        repair: bool,
        read_albedo: bool,
    ) -> PyResult<(Self, Vec<String>)> {
        let options = ReadOptions {
            non_finite: if repair { NonFinite::Drop } else { NonFinite::Refuse },
            up: match up {
                "y" => UpAxis::Y,
                "z" => UpAxis::Z,
                _ => return Err(PyValueError::new_err(format!("up is \"{up}\"; expected y or z"))),
            },
            albedo: if read_albedo { AlbedoSource::File } else { AlbedoSource::White },
        };
        let open = || ylm_prt::scene::Mesh::open_and_count(&path, &options);
        let (mesh, repairs) = py.detach(open).map_err(raise)?;
        let mut notes = repairs.missing;
        if repairs.dropped_vertex_count > 0 {
            notes.push(format!(
                "dropped {} vertices that are not finite, and {} faces that use them",
                repairs.dropped_vertex_count, repairs.dropped_face_count
            ));
        }
        if repairs.whitened_vertex_count > 0 {
            notes.push(format!(
                "made {} vertices white whose colour is no albedo",
                repairs.whitened_vertex_count
            ));
        }
        Ok((Self(mesh), notes))
    }

    /// A built-in scene.
    #[staticmethod]
    fn demo(name: &str) -> PyResult<Self> {
        match name {
            "scene" => Ok(Self(demo::scene())),
            "room" => Ok(Self(demo::cornell())),
            _ => Err(PyValueError::new_err(format!("there is no scene \"{name}\"; expected scene or room"))),
        }
    }

    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array_of(py, crate::light::flat(&self.0.positions), &[self.0.positions.len(), 3])
    }

    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array_of(py, self.0.triangles.as_flattened().to_vec(), &[self.0.triangles.len(), 3])
    }

    fn joined(&self, other: &Self) -> PyResult<Self> {
        let mut mesh = self.0.clone();
        mesh.append(&other.0).map_err(raise)?;
        Ok(Self(mesh))
    }

    fn painted(&self, albedo: [f32; 3]) -> PyResult<Self> {
        check_albedo(&albedo)?;
        let mut mesh = self.0.clone();
        mesh.paint(albedo);
        Ok(Self(mesh))
    }

    fn surface_area(&self) -> f64 {
        self.0.surface_area()
    }
}

/// Finite vectors [count, 3].
pub fn vectors(what: &str, object: &Bound<'_, PyAny>, count: Option<usize>) -> PyResult<Vec<Vec3>> {
    let array: Array<'_, f32> = float_array((what, object))?;
    if array.ndim() != 2 || count.is_some_and(|count| array.shape()[0] != count) {
        let expected = count.map_or("(p, 3)".to_owned(), |count| format!("({count}, 3)"));
        return Err(wrong_shape(what, array.shape(), &expected));
    }
    let (_, list) = rows::<f32, 3>(what, &array)?;
    match list.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
        Some(row) => {
            Err(PyValueError::new_err(format!("row {row} of {what} is {:?}; it must be finite", list[row])))
        }
        None => Ok(list.iter().map(|v| Vec3::from(*v)).collect()),
    }
}

fn check_albedo(albedo: &[f32; 3]) -> PyResult<()> {
    if albedo.iter().all(|value| (0.0..=1.0).contains(value)) {
        return Ok(());
    }
    Err(PyValueError::new_err(format!("an albedo is {albedo:?}; each must be 0 to 1")))
}

/// One material a position, if there is any.
fn materials(
    albedo: Option<&Bound<'_, PyAny>>,
    emission: Option<&Bound<'_, PyAny>>,
    count: usize,
) -> PyResult<Option<Vec<Material>>> {
    if albedo.is_none() && emission.is_none() {
        return Ok(None);
    }
    let mut values = vec![Material::WHITE; count];
    if let Some(albedo) = albedo {
        for (value, albedo) in values.iter_mut().zip(vectors("albedo", albedo, Some(count))?) {
            value.albedo = albedo.to_array();
            check_albedo(&value.albedo)?;
        }
    }
    if let Some(emission) = emission {
        for (value, emission) in values.iter_mut().zip(vectors("emission", emission, Some(count))?) {
            value.emission = emission.to_array();
            if value.emission.iter().any(|value| *value < 0.0) {
                let message = format!("an emission is {:?}; it must not be negative", value.emission);
                return Err(PyValueError::new_err(message));
            }
        }
    }
    Ok(Some(values))
}
