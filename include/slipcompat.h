/* Everything that depends on the version of PETSc, or on the compiler. Built against PETSc 3.18; breaks up to 3.25 are
   met here. */
#pragma once
#include <petscconf.h>
#include <petscversion.h>
#include <petscsys.h>

/* The PETSc that the library was built against; its structs, and the size of PetscInt, are those of no other. */
#if defined(__has_include)
  #if __has_include(<slipbuild.h>)
    #include <slipbuild.h>
    #if SLIPSTEP_PETSC_MAJOR != PETSC_VERSION_MAJOR || SLIPSTEP_PETSC_MINOR != PETSC_VERSION_MINOR
      #error "SlipStep was built against another PETSc than this: slipbuild.h names it. Compile with that one."
    #endif
    #if (SLIPSTEP_PETSC_INT_BITS == 64) != defined(PETSC_USE_64BIT_INDICES)
      #error "SlipStep was built against a PETSc with another PetscInt: slipbuild.h names it. Compile with that one."
    #endif
  #endif
#endif

#if PETSC_VERSION_LT(3, 19, 0) && !defined(PETSC_SUCCESS)
  #define PETSC_SUCCESS ((PetscErrorCode)0)
#endif
#if PETSC_VERSION_LT(3, 20, 0) && !defined(PetscAssertPointer)
  #define PetscAssertPointer(p, arg) PetscValidPointer(p, arg)
#endif
/* Type of the options argument of a setfromoptions op: a pointer until 3.22, by value from 3.23. */
#if PETSC_VERSION_LT(3, 23, 0)
typedef PetscOptionItems *SlipOptionItems;
#else
typedef PetscOptionItems SlipOptionItems;
#endif
/* Function type that MatShellSetOperation and MatSetOperation take. */
#if PETSC_VERSION_LT(3, 24, 0)
typedef void(SlipMatFn)(void);
  #define SlipMatShellFn(f) ((void (*)(void))(f))
#else
typedef PetscErrorCodeFn SlipMatFn;
  #define SlipMatShellFn(f) ((PetscErrorCodeFn *)(f))
#endif
/* No limit on failed solves and rejections. */
#if PETSC_VERSION_LT(3, 22, 0)
  #define SLIP_UNLIMITED (-1)
#else
  #define SLIP_UNLIMITED PETSC_UNLIMITED
#endif
/* Defaults of a SNES type that the user's own tolerances survive; needs petsc/private/snesimpl.h where it is used. */
#if PETSC_VERSION_LT(3, 22, 0)
  #define SlipSNESDefaults(snes, r, m)                                                                                 \
    do {                                                                                                               \
      if (!(snes)->tolerancesset) {                                                                                    \
        (snes)->rtol = (r);                                                                                            \
        (snes)->max_its = (m);                                                                                         \
      }                                                                                                                \
    } while (0)
#else
  #define SlipSNESDefaults(snes, r, m)                                                                                 \
    do {                                                                                                               \
      PetscCall(SNESParametersInitialize(snes));                                                                       \
      PetscObjectParameterSetDefault(snes, rtol, r);                                                                   \
      PetscObjectParameterSetDefault(snes, max_its, m);                                                                \
    } while (0)
#endif
/* The MPI type of PetscBool, an enumeration until 3.23, which then has no name of PETSc's own. */
#if PETSC_VERSION_GE(3, 24, 0)
  #undef MPIU_BOOL
  #define MPIU_BOOL MPI_C_BOOL
#endif
#if PETSC_VERSION_LT(3, 25, 0)
  #define SLIP_SNES_DIVERGED_NAN SNES_DIVERGED_FNORM_NAN
#else
  #define SLIP_SNES_DIVERGED_NAN SNES_DIVERGED_FUNCTION_NANORINF
#endif
/* The option of the first step; the other name is taken as well, see SlipErrorHandlerPush(). */
#if PETSC_VERSION_LT(3, 25, 0)
  #define SLIP_TS_DT "ts_dt"
  #define SLIP_TS_DT_OTHER "ts_time_step"
#else
  #define SLIP_TS_DT "ts_time_step"
  #define SLIP_TS_DT_OTHER "ts_dt"
#endif
/* The function that destroys what a PetscContainer holds gets the pointer until 3.22, the pointer's address from 3.23:
     static PetscErrorCode XDestroy_Container(SlipContainerArg arg) { X *x = SlipContainerArgPointer(arg); ... } */
#if PETSC_VERSION_LT(3, 23, 0)
typedef void *SlipContainerArg;
  #define SlipContainerArgPointer(arg) (arg)
  #define SlipContainerSetDestroy(c, f) PetscContainerSetUserDestroy(c, f)
  #define SlipContainerDestroyDefault PetscContainerUserDestroyDefault
#else
  #if PETSC_VERSION_LT(3, 25, 0)
typedef void **SlipContainerArg;
  #else
typedef PetscCtxRt SlipContainerArg;
  #endif
  #define SlipContainerArgPointer(arg) (*(void **)(arg))
  #define SlipContainerSetDestroy(c, f) PetscContainerSetCtxDestroy(c, f)
  #define SlipContainerDestroyDefault PetscCtxDestroyDefault
#endif

/* Loops for vector units: of functions so marked there is a version for each kind of processor, and a run takes that of
   the machine that it meets, not only of the one that compiled it. */
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) &&                       \
  !defined(__SANITIZE_ADDRESS__)
  #define SLIP_VECTOR __attribute__((target_clones("avx512f", "avx2,fma", "default")))
#else
  #define SLIP_VECTOR
#endif

/* Of a function that these call, with constants that choose its loop */
#if defined(__GNUC__)
  #define SLIP_VECTOR_PART static inline __attribute__((always_inline))
#else
  #define SLIP_VECTOR_PART static inline
#endif
