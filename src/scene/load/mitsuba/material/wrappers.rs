//! The bsdfs of a Mitsuba scene that wrap others: two sides, masks, normal maps, bumps, blends.
//!
//! Measure: opacities and weights without unit.
//! Range: a bsdf without the nested ones that it requires is an error.
//! Source: Mitsuba 3 documentation, "BSDFs". Tested in `tests/loading/mitsuba.rs`.

use super::BsdfReader;
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use crate::scene::description::{
    BumpMapDescription, ClearCoatDescription, ColourDescription, MaterialDescription,
    MaterialModel, NormalMapDescription, NoteKind,
};
use crate::scene::load::mitsuba::object::XmlObject;
use crate::scene::load::mitsuba::spectra::ColourMeaning;
use crate::scene::load::mitsuba::texture;
use std::rc::Rc;
use std::sync::Arc;

impl BsdfReader<'_> {
    pub(super) fn two_sided(
        &mut self,
        bsdf: &XmlObject,
        made: &mut MaterialDescription,
    ) -> Result<()> {
        let mut sides = bsdf.children("bsdf");
        let front = sides
            .next()
            .ok_or_else(|| bsdf.error("expected a nested bsdf"))?;
        if sides.next().is_some_and(|back| !Rc::ptr_eq(back, front)) {
            self.note(bsdf, NoteKind::Approximation, "the back is like the front");
        }
        self.read(front, made)?;
        made.two_sided = true;
        Ok(())
    }

    pub(super) fn mask(&mut self, bsdf: &XmlObject, made: &mut MaterialDescription) -> Result<()> {
        let opacity = self.colour(bsdf, "opacity", Rgb::grey(0.5), ColourMeaning::Colour)?;
        made.alpha = match opacity.constant() {
            Some(opacity) => opacity.map(|x| x.min(1.0)).into(),
            None => opacity,
        };
        self.nested(bsdf, made)
    }

    pub(super) fn normal_mapped(
        &mut self,
        bsdf: &XmlObject,
        made: &mut MaterialDescription,
    ) -> Result<()> {
        self.nested(bsdf, made)?;
        self.begin_detail(bsdf, made)?;
        let texture = self.nested_texture(bsdf, ColourMeaning::Normals)?;
        made.normal_map = texture.map(|texture| NormalMapDescription {
            texture,
            strength: 1.0,
            is_right_handed: true,
        });
        Ok(())
    }

    pub(super) fn bump_mapped(
        &mut self,
        bsdf: &XmlObject,
        made: &mut MaterialDescription,
    ) -> Result<()> {
        self.nested(bsdf, made)?;
        self.begin_detail(bsdf, made)?;
        let height = bsdf.number("scale")?.unwrap_or(1.0) as f32;
        let texture = self.nested_texture(bsdf, ColourMeaning::Colour)?;
        made.bump_map = texture.map(|texture| BumpMapDescription { texture, height });
        Ok(())
    }

    /// A coat of versions before 2 over its nested bsdf, which is a clear coat over metal and other opaque surfaces.
    pub(super) fn coating(
        &mut self,
        bsdf: &XmlObject,
        made: &mut MaterialDescription,
    ) -> Result<()> {
        self.nested(bsdf, made)?;
        let ior = self.ior(bsdf, "bk7")?.max(1.0);
        let roughness = self.roughness(bsdf)?;
        bsdf.number("thickness")?;
        if made.model.takes_clear_coat() {
            let text = "light between the coat and its base is that of our clear coat";
            self.note(bsdf, NoteKind::Approximation, text);
            made.clear_coat = Some(ClearCoatDescription {
                weight: 1.0,
                roughness,
                ior,
            });
        } else {
            self.note(bsdf, NoteKind::Omission, "the coat is left out");
        }
        Ok(())
    }

    /// Removes the map of normals or heights of a nested bsdf, which another one replaces, and notes what Mitsuba does with
    /// tilted normals.
    fn begin_detail(&mut self, bsdf: &XmlObject, made: &mut MaterialDescription) -> Result<()> {
        let (normals, heights) = (made.normal_map.take(), made.bump_map.take());
        if normals.is_some() || heights.is_some() {
            let text = "replaces the map of normals or heights of its nested bsdf";
            self.note(bsdf, NoteKind::Approximation, text);
        }
        bsdf.truth("flip_invalid_normals", true)?;
        if bsdf.truth("use_shadowing_function", true)? {
            let text = "tilted surfaces are not darkened by a shadowing function";
            self.note(bsdf, NoteKind::Approximation, text);
        }
        Ok(())
    }

    /// Two diffuse surfaces of constant colour blend exactly; of others, the one with the greater weight remains.
    pub(super) fn blend(&mut self, bsdf: &XmlObject, made: &mut MaterialDescription) -> Result<()> {
        let sides: Vec<_> = bsdf.children("bsdf").collect();
        let [first, second] = sides.as_slice() else {
            return Err(bsdf.error("expected two nested bsdfs"));
        };
        let weight = self.mean_of(|reader| {
            reader.colour(bsdf, "weight", Rgb::grey(0.5), ColourMeaning::Colour)
        })?;
        let weight = texture::mean(&weight).clamp(0.0, 1.0) as f32;
        let mut other = made.clone();
        let outer = self.to_uv;
        self.read(first, made)?;
        let of_first = std::mem::replace(&mut self.to_uv, outer);
        self.read(second, &mut other)?;
        let of_second = std::mem::replace(&mut self.to_uv, of_first);
        if let (
            MaterialModel::Diffuse { reflectance: a },
            MaterialModel::Diffuse { reflectance: b },
        ) = (&mut made.model, &other.model)
            && let (Some(x), Some(y)) = (a.constant(), b.constant())
        {
            *a = x.lerp(y, weight).into();
            return Ok(());
        }
        if weight > 0.5 {
            *made = other;
            self.to_uv = of_second;
        }
        self.note(
            bsdf,
            NoteKind::Approximation,
            "replaced by the one of greater weight",
        );
        Ok(())
    }

    /// The texture inside a bsdf; `None` if it is of one colour.
    fn nested_texture(
        &mut self,
        bsdf: &XmlObject,
        kind: ColourMeaning,
    ) -> Result<Option<Arc<Texture>>> {
        let texture = bsdf.children("texture").next();
        let texture = texture.ok_or_else(|| bsdf.error("expected a nested texture"))?;
        Ok(match self.texture(texture, kind)? {
            ColourDescription::Texture(texture) => Some(texture),
            ColourDescription::Constant(_) => None,
        })
    }

    fn nested(&mut self, bsdf: &XmlObject, made: &mut MaterialDescription) -> Result<()> {
        let inner = bsdf.children("bsdf").next();
        let inner = inner.ok_or_else(|| bsdf.error("expected a nested bsdf"))?;
        self.read(inner, made)
    }
}
