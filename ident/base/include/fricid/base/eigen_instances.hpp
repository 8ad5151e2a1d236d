// Eigen with explicit instantiations of its kernels and decompositions for double. They are
// compiled once, in eigen_instances.cpp; a source that includes only Eigen compiles its own.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

#ifndef FRICID_INSTANCE
#define FRICID_INSTANCE extern template
#endif

// later versions of Eigen have other template parameters
#if !EIGEN_VERSION_AT_LEAST(3, 4, 90)

namespace Eigen {
namespace internal {

using KernelTraits = gebp_traits<double, double>;
using ResultMapper = blas_data_mapper<double, Index, ColMajor, Unaligned, 1>;
template <int Order>
using InputMapper = const_blas_data_mapper<double, Index, Order>;

// matrix times matrix
FRICID_INSTANCE struct gebp_kernel<double, double, Index, ResultMapper, KernelTraits::mr,
                                   KernelTraits::nr, false, false>;
FRICID_INSTANCE struct gemm_pack_lhs<double, Index, InputMapper<ColMajor>, KernelTraits::mr,
                                     KernelTraits::LhsProgress, KernelTraits::LhsPacket4Packing,
                                     ColMajor>;
FRICID_INSTANCE struct gemm_pack_lhs<double, Index, InputMapper<RowMajor>, KernelTraits::mr,
                                     KernelTraits::LhsProgress, KernelTraits::LhsPacket4Packing,
                                     RowMajor>;
FRICID_INSTANCE struct gemm_pack_lhs<double, Index, ResultMapper, KernelTraits::mr,
                                     KernelTraits::LhsProgress, KernelTraits::LhsPacket4Packing,
                                     ColMajor, false, true>;
FRICID_INSTANCE struct gemm_pack_rhs<double, Index, InputMapper<ColMajor>, KernelTraits::nr,
                                     ColMajor>;
FRICID_INSTANCE struct gemm_pack_rhs<double, Index, InputMapper<RowMajor>, KernelTraits::nr,
                                     RowMajor>;
FRICID_INSTANCE struct gemm_pack_rhs<double, Index, ResultMapper, KernelTraits::nr, ColMajor, false,
                                     true>;
FRICID_INSTANCE struct general_matrix_matrix_product<Index, double, ColMajor, false, double,
                                                     ColMajor, false, ColMajor, 1>;
FRICID_INSTANCE struct general_matrix_matrix_product<Index, double, ColMajor, false, double,
                                                     RowMajor, false, ColMajor, 1>;
FRICID_INSTANCE struct general_matrix_matrix_product<Index, double, RowMajor, false, double,
                                                     ColMajor, false, ColMajor, 1>;
FRICID_INSTANCE struct general_matrix_matrix_product<Index, double, RowMajor, false, double,
                                                     RowMajor, false, ColMajor, 1>;
FRICID_INSTANCE void evaluateProductBlockingSizesHeuristic<double, double, 1, Index>(Index&, Index&,
                                                                                     Index&, Index);
FRICID_INSTANCE void evaluateProductBlockingSizesHeuristic<double, double, 4, Index>(Index&, Index&,
                                                                                     Index&, Index);

// matrix times vector; a vector is a row or a column of a matrix of either order
FRICID_INSTANCE struct general_matrix_vector_product<Index, double, InputMapper<ColMajor>, ColMajor,
                                                     false, double, InputMapper<RowMajor>, false>;
FRICID_INSTANCE struct general_matrix_vector_product<Index, double, InputMapper<ColMajor>, ColMajor,
                                                     false, double, InputMapper<ColMajor>, false>;
FRICID_INSTANCE struct general_matrix_vector_product<Index, double, InputMapper<RowMajor>, RowMajor,
                                                     false, double, InputMapper<ColMajor>, false>;
FRICID_INSTANCE struct general_matrix_vector_product<Index, double, InputMapper<RowMajor>, RowMajor,
                                                     false, double, InputMapper<RowMajor>, false,
                                                     BuiltIn>;
FRICID_INSTANCE struct selfadjoint_matrix_vector_product<double, Index, ColMajor, Lower, false,
                                                         false>;

// triangular systems
FRICID_INSTANCE struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor,
                                               ColMajor, 1>;
FRICID_INSTANCE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, RowMajor,
                                               ColMajor, 1>;
FRICID_INSTANCE struct triangular_solve_matrix<double, Index, OnTheRight, Upper, false, RowMajor,
                                               ColMajor, 1>;
FRICID_INSTANCE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, ColMajor,
                                               ColMajor, 1>;
FRICID_INSTANCE struct triangular_solve_matrix<double, Index, OnTheLeft, UnitLower, false, ColMajor,
                                               ColMajor, 1>;
FRICID_INSTANCE struct triangular_solve_vector<double, double, Index, OnTheLeft, Lower, false,
                                               ColMajor>;
FRICID_INSTANCE struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false,
                                               RowMajor>;

}  // namespace internal

FRICID_INSTANCE SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(
    const EigenBase<MatrixXd>&, int);
FRICID_INSTANCE LLT<MatrixXd>& LLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
FRICID_INSTANCE LDLT<MatrixXd>& LDLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
FRICID_INSTANCE void LDLT<MatrixXd>::_solve_impl_transposed<true>(const VectorXd&, VectorXd&) const;
FRICID_INSTANCE void ColPivHouseholderQR<MatrixXd>::computeInPlace();

}  // namespace Eigen

#endif
