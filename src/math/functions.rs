//! Transcendental functions with the same bits on every processor.
//!
//! The C library, which the functions of the standard library call, chooses other code where the processor has fused
//! multiply-adds, and other versions of it have other code: the last bits differ. These functions are compiled with the
//! renderer. A test holds the sources to them.
//!
//! Measure: radians.
//! Range: that of each function of the standard library; errors below one unit in the last place, but two for `powf`.
//! Source: the crate libm, a port of musl's. Tested below.

/// A floating-point type with these functions.
pub trait Float: Copy {
    /// As [`sin`].
    fn sin(self) -> Self;
    /// As [`cos`].
    fn cos(self) -> Self;
    /// As [`sin_cos`].
    fn sin_cos(self) -> (Self, Self);
    /// As [`tan`].
    fn tan(self) -> Self;
    /// As [`asin`].
    fn asin(self) -> Self;
    /// As [`acos`].
    fn acos(self) -> Self;
    /// As [`atan`].
    fn atan(self) -> Self;
    /// As [`atan2`].
    fn atan2(self, x: Self) -> Self;
    /// As [`exp`].
    fn exp(self) -> Self;
    /// As [`exp2`].
    fn exp2(self) -> Self;
    /// As [`exp_m1`].
    fn exp_m1(self) -> Self;
    /// As [`ln`].
    fn ln(self) -> Self;
    /// As [`log2`].
    fn log2(self) -> Self;
    /// As [`ln_1p`].
    fn ln_1p(self) -> Self;
    /// As [`powf`].
    fn powf(self, exponent: Self) -> Self;
    /// As [`cbrt`].
    fn cbrt(self) -> Self;
    /// As [`hypot`].
    fn hypot(self, y: Self) -> Self;
}

macro_rules! float {
    ($type:ty: $sin:ident $cos:ident $sincos:ident $tan:ident $asin:ident $acos:ident $atan:ident $atan2:ident
        $exp:ident $exp2:ident $expm1:ident $log:ident $log2:ident $log1p:ident $pow:ident $cbrt:ident $hypot:ident) => {
        impl Float for $type {
            fn sin(self) -> Self {
                libm::$sin(self)
            }
            fn cos(self) -> Self {
                libm::$cos(self)
            }
            fn sin_cos(self) -> (Self, Self) {
                libm::$sincos(self)
            }
            fn tan(self) -> Self {
                libm::$tan(self)
            }
            fn asin(self) -> Self {
                libm::$asin(self)
            }
            fn acos(self) -> Self {
                libm::$acos(self)
            }
            fn atan(self) -> Self {
                libm::$atan(self)
            }
            fn atan2(self, x: Self) -> Self {
                libm::$atan2(self, x)
            }
            fn exp(self) -> Self {
                libm::$exp(self)
            }
            fn exp2(self) -> Self {
                libm::$exp2(self)
            }
            fn exp_m1(self) -> Self {
                libm::$expm1(self)
            }
            fn ln(self) -> Self {
                libm::$log(self)
            }
            fn log2(self) -> Self {
                libm::$log2(self)
            }
            fn ln_1p(self) -> Self {
                libm::$log1p(self)
            }
            fn powf(self, exponent: Self) -> Self {
                libm::$pow(self, exponent)
            }
            fn cbrt(self) -> Self {
                libm::$cbrt(self)
            }
            fn hypot(self, y: Self) -> Self {
                libm::$hypot(self, y)
            }
        }
    };
}

float!(f32: sinf cosf sincosf tanf asinf acosf atanf atan2f
    expf exp2f expm1f logf log2f log1pf powf cbrtf hypotf);
float!(f64: sin cos sincos tan asin acos atan atan2
    exp exp2 expm1 log log2 log1p pow cbrt hypot);

/// Sine.
pub fn sin<T: Float>(x: T) -> T {
    x.sin()
}

/// Cosine.
pub fn cos<T: Float>(x: T) -> T {
    x.cos()
}

/// Sine and cosine.
pub fn sin_cos<T: Float>(x: T) -> (T, T) {
    x.sin_cos()
}

/// Tangent.
pub fn tan<T: Float>(x: T) -> T {
    x.tan()
}

/// Inverse sine, from -pi/2 to pi/2.
pub fn asin<T: Float>(x: T) -> T {
    x.asin()
}

/// Inverse cosine, from 0 to pi.
pub fn acos<T: Float>(x: T) -> T {
    x.acos()
}

/// Inverse tangent, from -pi/2 to pi/2.
pub fn atan<T: Float>(x: T) -> T {
    x.atan()
}

/// The angle of the point (x, y), from -pi to pi.
pub fn atan2<T: Float>(y: T, x: T) -> T {
    y.atan2(x)
}

/// e^x.
pub fn exp<T: Float>(x: T) -> T {
    x.exp()
}

/// 2^x.
pub fn exp2<T: Float>(x: T) -> T {
    x.exp2()
}

/// e^x - 1, accurate near 0.
pub fn exp_m1<T: Float>(x: T) -> T {
    x.exp_m1()
}

/// The natural logarithm.
pub fn ln<T: Float>(x: T) -> T {
    x.ln()
}

/// The logarithm to base 2.
pub fn log2<T: Float>(x: T) -> T {
    x.log2()
}

/// ln(1 + x), accurate near 0.
pub fn ln_1p<T: Float>(x: T) -> T {
    x.ln_1p()
}

/// x^exponent.
pub fn powf<T: Float>(x: T, exponent: T) -> T {
    x.powf(exponent)
}

/// The cube root.
pub fn cbrt<T: Float>(x: T) -> T {
    x.cbrt()
}

/// sqrt(x^2 + y^2), without overflow.
pub fn hypot<T: Float>(x: T, y: T) -> T {
    x.hypot(y)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the standard library, whose C library is accurate to one unit in the last place as well.
    #[test]
    fn functions_agree_with_the_standard_library() {
        let near = |name: &str, x: f64, ours: f64, std: f64| {
            let error = (ours - std).abs() / std.abs().max(f64::MIN_POSITIVE);
            assert!(error < 1e-15, "{name} of {x}: {ours} {std}");
        };
        for i in 1..2000 {
            let x = f64::from(i) * 4.99e-4;
            near("sin", x, sin(x), x.sin());
            near("cos", x, cos(x), x.cos());
            near("tan", x, tan(x), x.tan());
            near("asin", x, asin(x), x.asin());
            near("acos", x, acos(x), x.acos());
            near("atan", x, atan(x), x.atan());
            near("atan2", x, atan2(x, -0.3), x.atan2(-0.3));
            near("exp", x, exp(x), x.exp());
            near("exp2", x, exp2(x), x.exp2());
            near("exp_m1", x, exp_m1(x), x.exp_m1());
            near("ln", x, ln(x), x.ln());
            near("log2", x, log2(x), x.log2());
            near("ln_1p", x, ln_1p(x), x.ln_1p());
            near("powf", x, powf(x, 1.7), x.powf(1.7));
            near("cbrt", x, cbrt(x), x.cbrt());
            near("hypot", x, hypot(x, 0.7), x.hypot(0.7));
            assert_eq!(sin_cos(x), (sin(x), cos(x)));
        }
        assert_eq!(sin(0.5_f32), 0.5_f32.sin());
    }

    /// The bits of values whose last ones the C library gives otherwise on processors without fused multiply-adds.
    #[test]
    fn functions_have_the_same_bits_everywhere() {
        let mut sum = 0_u64;
        for i in 1..20_000 {
            let x = f64::from(i) * 4.3137e-5;
            for value in [
                sin(x),
                cos(x),
                exp(x),
                ln(x),
                atan(x),
                asin(x),
                acos(x),
                powf(x, 1.37),
            ] {
                sum = sum.rotate_left(7) ^ value.to_bits();
            }
        }
        assert_eq!(sum, EXPECTED);
    }

    const EXPECTED: u64 = 0x5008_3354_0917_ce13;
}
