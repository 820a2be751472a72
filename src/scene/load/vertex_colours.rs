//! Colours of vertices as a texture: a block of 2 x 2 texels per triangle, and texture coordinates that point into it.
//!
//! The corners of a triangle get the centres of three texels of its block. Bilinear interpolation between four texels
//! is linear if the fourth is the sum of its neighbours minus the opposite one, so that the colour is interpolated as
//! usual, linearly over the triangle.
//!
//! Measure: linear Rec. 709.
//! Range: at least 0; where the fourth texel would be below 0 or above the brightest colour it is clamped, which bends
//! the interpolation by at most a quarter of the excess. The corner with the least excess is chosen.
//! Source: none needed. Tested below.

use super::contents::SceneContents;
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::image::Image;
use crate::math::rgb::Rgb;
use crate::math::vec::DVec2;
use crate::memory;
use crate::scene::description::{
    ColourDescription, MaterialDescription, MaterialModel, MeshDescription, Place,
};
use std::sync::Arc;

/// Adds a diffuse material of the colours of a mesh's vertices, and returns its index. The mesh is changed as by
/// [`to_texture`].
///
/// # Errors
/// If there is too little memory.
pub fn to_material(
    mesh: &mut MeshDescription,
    colours: &[Rgb],
    place: Place,
    contents: &mut SceneContents,
) -> Result<usize> {
    let reflectance = to_texture(mesh, colours)?;
    let model = MaterialModel::Diffuse { reflectance };
    Ok(contents.add_material(MaterialDescription::new("colours", place, model)))
}

/// Gives each triangle vertices of its own, whose texture coordinates point into the texture that is returned. Existing
/// texture coordinates are replaced. `colours` has one entry per vertex.
///
/// # Errors
/// If there is too little memory.
pub fn to_texture(mesh: &mut MeshDescription, colours: &[Rgb]) -> Result<ColourDescription> {
    let mut used = mesh.indices.iter().flatten().map(|&i| colours[i as usize]);
    let first = used.next().unwrap_or(Rgb::BLACK);
    if used.all(|colour| colour == first) {
        return Ok(ColourDescription::Constant(first));
    }
    let count = mesh.indices.len();
    memory::check(count as u64 * BYTES, || {
        "the colours of the vertices".to_owned()
    })?;
    let columns = (count as f64).sqrt().ceil() as usize;
    let rows = count.div_ceil(columns);
    let (width, height) = (2 * columns, 2 * rows);
    let mut texels = vec![Rgb::BLACK; width * height];
    let brightest = colours.iter().fold(0.0_f32, |b, c| b.max(c.max_channel()));
    let mut uvs = Vec::with_capacity(3 * count);
    let mut corners = Vec::with_capacity(3 * count);
    for (index, triangle) in mesh.indices.iter().enumerate() {
        let (x, y) = (2 * (index % columns), 2 * (index / columns));
        let block = TriangleTexels::around(triangle.map(|i| colours[i as usize]), brightest);
        for corner in 0..3 {
            // The places of the corners in the block, counter-clockwise from the one opposite to the fourth texel.
            let (dx, dy) = [(0, 0), (1, 0), (0, 1)][(corner + 3 - block.origin) % 3];
            texels[(y + dy) * width + x + dx] = block.colours[corner];
            let centre = DVec2::new((x + dx) as f64 + 0.5, (y + dy) as f64 + 0.5);
            uvs.push(DVec2::new(
                centre.x / width as f64,
                1.0 - centre.y / height as f64,
            ));
            corners.push(triangle[corner] as usize);
        }
        texels[(y + 1) * width + x + 1] = block.fourth;
    }
    mesh.positions = corners.iter().map(|&i| mesh.positions[i]).collect();
    if !mesh.normals.is_empty() {
        mesh.normals = corners.iter().map(|&i| mesh.normals[i]).collect();
    }
    mesh.uvs = uvs;
    mesh.indices = (0..count as u32)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    let image = Arc::new(Image::new(width as u32, height as u32, texels).into());
    let scale = 1.0;
    Ok(ColourDescription::Texture(Arc::new(Texture::Image {
        image,
        scale,
    })))
}

/// Bytes of a triangle: four texels, and three vertices with normals and texture coordinates.
pub const BYTES: u64 = 4 * 16 + 3 * 64 + 3 * 8 + 12;

/// The four texels of a triangle.
struct TriangleTexels {
    colours: [Rgb; 3],
    /// The corner opposite to the fourth texel.
    origin: usize,
    fourth: Rgb,
}

impl TriangleTexels {
    fn around(colours: [Rgb; 3], brightest: f32) -> Self {
        let fourth = |origin: usize| {
            let [a, b, c] = [0, 1, 2].map(|i| colours[(origin + i) % 3].to_array());
            [0, 1, 2].map(|i| b[i] + c[i] - a[i])
        };
        let clamped = |colour: [f32; 3]| colour.map(|x| x.clamp(0.0, brightest));
        let excess = |origin: usize| {
            let colour = fourth(origin);
            let kept = clamped(colour);
            (0..3).map(|i| (colour[i] - kept[i]).abs()).sum::<f32>()
        };
        let by_excess = |&a: &usize, &b: &usize| excess(a).total_cmp(&excess(b));
        let origin = (0..3).min_by(by_excess).unwrap_or(0);
        Self {
            colours,
            origin,
            fourth: Rgb::from(clamped(fourth(origin))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::{DVec3, Vec2};

    #[test]
    fn colours_are_interpolated_linearly_over_each_triangle() {
        let mut mesh = MeshDescription {
            positions: [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
                .map(|(x, y)| DVec3::new(x, y, 0.0))
                .to_vec(),
            indices: vec![[0, 1, 2], [0, 2, 3], [3, 1, 2]],
            ..MeshDescription::default()
        };
        let colours = [
            Rgb::new(0.2, 0.5, 0.4),
            Rgb::new(0.5, 0.6, 0.5),
            Rgb::new(0.4, 0.3, 0.6),
            Rgb::new(0.3, 0.7, 0.5),
        ];
        let before = mesh.clone();
        let ColourDescription::Texture(texture) = to_texture(&mut mesh, &colours).expect("memory")
        else {
            panic!("more than one colour")
        };
        for (old, new) in before.indices.iter().zip(&mesh.indices) {
            let old = old.map(|i| i as usize);
            let new = new.map(|i| i as usize);
            assert_eq!(
                new.map(|i| mesh.positions[i]),
                old.map(|i| before.positions[i])
            );
            for [u, v] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.2, 0.3], [0.5, 0.5]] {
                let weights = [1.0 - u - v, u, v];
                let uv = (0..3).map(|i| weights[i] * mesh.uvs[new[i]]).sum::<DVec2>();
                let found = texture
                    .lookup(Vec2::new(uv.x as f32, uv.y as f32))
                    .to_array();
                for (channel, found) in found.iter().enumerate() {
                    let expected: f32 = (0..3)
                        .map(|i| weights[i] as f32 * colours[old[i]].to_array()[channel])
                        .sum();
                    assert!((found - expected).abs() < 1e-5, "{found} for {expected}");
                }
            }
        }
    }

    #[test]
    fn uniform_colour_is_constant_and_texels_are_non_negative() {
        let mut mesh = MeshDescription {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            indices: vec![[0, 1, 2]],
            ..MeshDescription::default()
        };
        let one = to_texture(&mut mesh, &[Rgb::WHITE; 3]).expect("memory");
        assert_eq!(one.constant(), Some(Rgb::WHITE));
        let primaries = [
            Rgb::new(1.0, 0.0, 0.0),
            Rgb::new(0.0, 1.0, 0.0),
            Rgb::new(0.0, 0.0, 1.0),
        ];
        let three = to_texture(&mut mesh, &primaries).expect("memory");
        let ColourDescription::Texture(texture) = three else {
            panic!("three colours")
        };
        assert_eq!(texture.brightest(), Rgb::WHITE);
        let Texture::Image { image, .. } = &*texture else {
            panic!("an image")
        };
        assert!(
            image
                .texels()
                .all(|c| c.to_array().iter().all(|x| *x >= 0.0))
        );
    }
}
