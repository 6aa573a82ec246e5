/* All code that depends on the version of PETSc, or on the compiler. PETSc 3.18 is the base; changes of its interface
   up to 3.25 are handled here. */
#pragma once
#include <petscconf.h>
#include <petscversion.h>
#include <petscsys.h>

/* The library was built against one PETSc, and its structs and the size of PetscInt match no other. */
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
/* Type of the options argument of a setfromoptions operation: a pointer up to 3.22, a value from 3.23 on */
#if PETSC_VERSION_LT(3, 23, 0)
typedef PetscOptionItems *SlipOptionItems;
#else
typedef PetscOptionItems SlipOptionItems;
#endif
/* Function type that MatShellSetOperation() and MatSetOperation() take */
#if PETSC_VERSION_LT(3, 24, 0)
typedef void(SlipMatFn)(void);
  #define SlipMatShellFn(f) ((void (*)(void))(f))
#else
typedef PetscErrorCodeFn SlipMatFn;
  #define SlipMatShellFn(f) ((PetscErrorCodeFn *)(f))
#endif
/* Value for no limit on failed solves and rejections */
#if PETSC_VERSION_LT(3, 22, 0)
  #define SLIP_UNLIMITED (-1)
#else
  #define SLIP_UNLIMITED PETSC_UNLIMITED
#endif
/* Sets SNES defaults without overwriting tolerances of the user; users include petsc/private/snesimpl.h. */
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
/* The MPI type of PetscBool, which was an enumeration up to 3.23; after that PETSc has no name for it. */
#if PETSC_VERSION_GE(3, 24, 0)
  #undef MPIU_BOOL
  #define MPIU_BOOL MPI_C_BOOL
#endif
#if PETSC_VERSION_LT(3, 25, 0)
  #define SLIP_SNES_DIVERGED_NAN SNES_DIVERGED_FNORM_NAN
#else
  #define SLIP_SNES_DIVERGED_NAN SNES_DIVERGED_FUNCTION_NANORINF
#endif
/* The option of the first step in this version; SlipErrorHandlerPush() makes programs accept the other name as well. */
#if PETSC_VERSION_LT(3, 25, 0)
  #define SLIP_TS_DT "ts_dt"
  #define SLIP_TS_DT_OTHER "ts_time_step"
#else
  #define SLIP_TS_DT "ts_time_step"
  #define SLIP_TS_DT_OTHER "ts_dt"
#endif
/* The function that destroys the content of a PetscContainer gets the pointer until 3.22, its address from 3.23 on:
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

/* The compiler makes one version of a function marked SLIP_VECTOR for each kind of processor, and a run uses that of
   its machine, so that loops use vector units that the compiling machine may not have. */
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) &&                       \
  !defined(__SANITIZE_ADDRESS__)
  #define SLIP_VECTOR __attribute__((target_clones("avx512f", "avx2,fma", "default")))
#else
  #define SLIP_VECTOR
#endif

/* Marks a function that such functions call with constants, which choose its loop */
#if defined(__GNUC__)
  #define SLIP_VECTOR_PART static inline __attribute__((always_inline))
#else
  #define SLIP_VECTOR_PART static inline
#endif
