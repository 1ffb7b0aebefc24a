//! Host and WGSL agree on every struct they share: names, offsets, sizes.

use std::collections::HashMap;

use naga::TypeInner;
use renderer_core::gpu::layout::{STRUCTS, StructLayout};
use renderer_core::gpu::shaders::{Composed, ERROR, RESOLVE, TRACE};

fn programs() -> Vec<naga::Module> {
    [TRACE, RESOLVE, ERROR]
        .into_iter()
        .map(|parts| naga::front::wgsl::parse_str(&Composed::new(parts).text).expect("valid WGSL"))
        .collect()
}

type Members = Vec<(String, usize, usize)>;

/// Every struct of a module that lies in a buffer: size, and (name, offset, size) of its members.
fn structs(module: &naga::Module) -> HashMap<String, (usize, Members)> {
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).expect("layout");
    let mut found = HashMap::new();
    for (_, ty) in module.types.iter() {
        if let (Some(name), TypeInner::Struct { members, span }) = (&ty.name, &ty.inner) {
            let members = members
                .iter()
                .map(|member| {
                    (
                        member.name.clone().expect("members have names"),
                        member.offset as usize,
                        layouter[member.ty].size as usize,
                    )
                })
                .collect();
            found.insert(name.clone(), (*span as usize, members));
        }
    }
    found
}

/// What differs between a host struct and its WGSL twin.
fn difference(host: &StructLayout, wgsl: &(usize, Members)) -> Option<String> {
    let members: Members = host
        .members
        .iter()
        .map(|&(name, offset, size)| (name.to_owned(), offset, size))
        .collect();
    (members != wgsl.1 || host.size != wgsl.0).then(|| {
        format!(
            "{}: host {} {members:?}, WGSL {} {:?}",
            host.name, host.size, wgsl.0, wgsl.1
        )
    })
}

#[test]
fn structs_are_the_same_on_both_sides() {
    let modules = programs();
    for host in STRUCTS {
        let twins: Vec<_> = modules
            .iter()
            .filter_map(|module| structs(module).remove(host.name))
            .collect();
        assert!(!twins.is_empty(), "no struct {} in WGSL", host.name);
        for twin in twins {
            assert_eq!(difference(host, &twin), None);
        }
    }
}

#[test]
fn a_moved_member_would_be_noticed() {
    let module = programs().remove(0);
    for host in STRUCTS {
        let mut twin = structs(&module).remove(host.name).expect("is there");
        let last = twin.1.len() - 1;
        twin.1.swap(last, last - 1);
        assert!(difference(host, &twin).is_some(), "{} swapped", host.name);
        twin.1.swap(last, last - 1);
        twin.1[last].1 += 4;
        assert!(difference(host, &twin).is_some(), "{} moved", host.name);
    }
}
