//! The rotation nearest to a deformation gradient, including inverted ones.

use nalgebra::{Matrix3, Matrix4, SymmetricEigen, Vector3};

/// Newton iterations for the largest root; they converge from above, quadratically except at double
/// roots.
const NEWTON_STEPS: usize = 24;

/// Below this fraction of the quaternion its scalar part is a small difference: the rotation is
/// near a half turn.
const SCALAR_SHARE: f64 = 0.05;

/// The proper rotation R that maximises tr(RᵀF), hence minimises ‖F − R‖.
///
/// Horn (1987): it is the unit quaternion of the largest eigenvalue of a symmetric 4×4 matrix of F.
/// That holds for an inverted F too, where the plain polar decomposition would give a reflection.
pub(super) fn nearest_rotation(f: &Matrix3<f64>) -> Matrix3<f64> {
    let axis = Vector3::new(f.m32 - f.m23, f.m13 - f.m31, f.m21 - f.m12);
    let symmetric = f + f.transpose();
    quick(f, &symmetric, &axis).unwrap_or_else(|| by_eigenvectors(f, &symmetric, &axis))
}

/// The largest eigenvalue by Newton's method and its quaternion by Cramer's rule (Shuster and Oh
/// 1981). `None` near a half turn, or if the largest eigenvalue is nearly double.
fn quick(f: &Matrix3<f64>, symmetric: &Matrix3<f64>, axis: &Vector3<f64>) -> Option<Matrix3<f64>> {
    let trace = f.trace();
    let square = f.norm_squared();
    let cofactors = adjugate(f);
    // λ⁴ − 2‖F‖² λ² − 8 det F λ + (‖F‖⁴ − 2(‖F‖⁴ − ‖FᵀF‖²) …): its constant is ‖F‖⁴ − 4‖adj F‖².
    let determinant = f.row(0).transpose().dot(&cofactors.column(0));
    let constant = square * square - 4.0 * cofactors.norm_squared();
    let mut root = (3.0 * square).sqrt();
    for _ in 0..NEWTON_STEPS {
        let value = (root * root - 2.0 * square) * root * root - 8.0 * determinant * root + constant;
        let slope = 4.0 * (root * root - square) * root - 8.0 * determinant;
        let change = value / slope;
        if !change.is_finite() {
            return None;
        }
        root -= change;
        // Newton's method squares the remaining error.
        if change.abs() <= 1e-9 * root {
            break;
        }
    }
    let matrix = Matrix3::from_diagonal_element(root + trace) - symmetric;
    let adjugate = adjugate(&matrix);
    let scalar = matrix.row(0).transpose().dot(&adjugate.column(0));
    let vector = adjugate * axis;
    let norm = (scalar * scalar + vector.norm_squared()).sqrt();
    let scale = root + trace.abs();
    let clear = scalar.abs() > SCALAR_SHARE * norm && norm > 1e-3 * scale * scale * scale;
    clear.then(|| from_quaternion(scalar / norm, &(vector / norm)))
}

/// The same by the eigenvectors of the full matrix: slower, but without exceptions.
fn by_eigenvectors(f: &Matrix3<f64>, symmetric: &Matrix3<f64>, axis: &Vector3<f64>) -> Matrix3<f64> {
    let largest = f.amax();
    if !(largest > 0.0 && largest.is_finite()) {
        return Matrix3::identity();
    }
    let trace = f.trace();
    let mut matrix = Matrix4::from_diagonal_element(trace);
    matrix.fixed_view_mut::<3, 3>(1, 1).copy_from(&(symmetric - Matrix3::from_diagonal_element(trace)));
    matrix.fixed_view_mut::<3, 1>(1, 0).copy_from(axis);
    matrix.fixed_view_mut::<1, 3>(0, 1).copy_from(&axis.transpose());
    let Some(eigen) = SymmetricEigen::try_new(matrix / largest, f64::EPSILON, 200) else {
        return Matrix3::identity();
    };
    let quaternion = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    from_quaternion(quaternion[0], &Vector3::new(quaternion[1], quaternion[2], quaternion[3]))
}

/// The transposed matrix of cofactors: A · adj A = det A.
fn adjugate(a: &Matrix3<f64>) -> Matrix3<f64> {
    let [x, y, z] = [a.row(0).transpose(), a.row(1).transpose(), a.row(2).transpose()];
    Matrix3::from_columns(&[y.cross(&z), z.cross(&x), x.cross(&y)])
}

/// The rotation of a unit quaternion w + v: (w² − v·v) I + 2 v vᵀ + 2 w \[v\]×.
fn from_quaternion(w: f64, v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_diagonal_element(w * w - v.norm_squared()) + 2.0 * v * v.transpose() + 2.0 * w * v.cross_matrix()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Rotation3, Vector3};

    use super::{by_eigenvectors, nearest_rotation};

    fn stretched(turn: &Rotation3<f64>, stretch: [f64; 3]) -> Matrix3<f64> {
        turn.matrix() * Matrix3::from_diagonal(&Vector3::from(stretch))
    }

    #[test]
    fn a_turned_stretch_gives_back_its_turn_whatever_the_angle() {
        for degrees in [0.0, 1e-7, 30.0, 90.0, 150.0, 179.0, 180.0] {
            let turn = Rotation3::from_scaled_axis(Vector3::new(0.3, -0.5, 0.8).normalize() * f64::to_radians(degrees));
            let found = nearest_rotation(&stretched(&turn, [1.3, 0.8, 1.1]));
            assert!((found - turn.matrix()).amax() < 1e-13, "at {degrees}°: {found}");
        }
    }

    #[test]
    fn inverted_gradient_yields_the_nearest_proper_rotation() {
        let turn = Rotation3::from_euler_angles(0.4, -0.2, 0.9);
        let found = nearest_rotation(&stretched(&turn, [1.3, 1.1, -0.2]));
        assert!((found.determinant() - 1.0).abs() < 1e-12);
        assert!((found - turn.matrix()).amax() < 1e-10, "{found}");
    }

    #[test]
    fn both_ways_agree_and_none_fails_on_what_has_no_single_answer() {
        let turn = Rotation3::from_euler_angles(1.4, 0.3, -0.7);
        let f = stretched(&turn, [0.5, 2.0, 1.0]);
        let axis = Vector3::new(f.m32 - f.m23, f.m13 - f.m31, f.m21 - f.m12);
        assert!((nearest_rotation(&f) - by_eigenvectors(&f, &(f + f.transpose()), &axis)).amax() < 1e-12);
        for f in [Matrix3::zeros(), -Matrix3::identity(), Matrix3::from_diagonal_element(1e150), Matrix3::repeat(1.0)] {
            let found = nearest_rotation(&f);
            assert!((found * found.transpose() - Matrix3::identity()).amax() < 1e-9, "{f} gave {found}");
        }
    }
}
