//! The shaders are valid, and bound as the crate says.

use naga::front::wgsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, StorageAccess, TypeInner};
use ylm_gpu::{Access, BLOCK, Frame, Kernel, Place, Surface};

/// The module of a kernel, if it needs nothing beyond what every WebGPU has.
fn module(kernel: Kernel) -> naga::Module {
    let text = kernel.source();
    let module = wgsl::parse_str(text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(text)));
    let checked = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    checked.unwrap_or_else(|error| panic!("{}: {}", kernel.name(), error.emit_to_string(text)));
    module
}

#[test]
fn shaders_are_valid_and_have_one_entry_of_a_block() {
    for kernel in Kernel::ALL {
        let module = module(kernel);
        let [entry] = module.entry_points.as_slice() else { panic!("{}", kernel.name()) };
        assert_eq!(entry.name, "main");
        assert_eq!(entry.workgroup_size, [BLOCK as u32, 1, 1]);
    }
}

#[test]
fn buffers_of_shaders_are_those_of_their_kernels() {
    for kernel in Kernel::ALL {
        let module = module(kernel);
        let mut found: Vec<_> = module
            .global_variables
            .iter()
            .map(|(_, variable)| {
                let access = match variable.space {
                    AddressSpace::Uniform => Access::Uniform,
                    AddressSpace::Storage { access } if access == StorageAccess::LOAD => Access::Read,
                    AddressSpace::Storage { .. } => Access::Write,
                    other => panic!("{} has a variable in {other:?}", kernel.name()),
                };
                let place = variable.binding.unwrap();
                assert_eq!(place.group, 0);
                (place.binding as usize, variable.name.clone().unwrap(), access)
            })
            .collect();
        found.sort_by_key(|(binding, ..)| *binding);
        let stated: Vec<_> = (kernel.bindings().iter().enumerate())
            .map(|(binding, stated)| (binding, stated.name.to_owned(), stated.access))
            .collect();
        assert_eq!(found, stated, "{}", kernel.name());
    }
}

#[test]
fn structures_of_shaders_are_as_large_as_those_of_the_crate() {
    let module = module(Kernel::Diffuse);
    let size = |name: &str| {
        let is_named = |ty: &&naga::Type| ty.name.as_deref() == Some(name);
        match module.types.iter().map(|(_, ty)| ty).find(is_named).expect(name).inner {
            TypeInner::Struct { span, .. } => span as usize,
            ref other => panic!("{other:?}"),
        }
    };
    assert_eq!(size("Frame"), size_of::<Frame>());
    assert_eq!(size("Place"), size_of::<Place>());
    assert_eq!(size("Surface"), size_of::<Surface>());
}
