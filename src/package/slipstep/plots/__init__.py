"""Pictures of runs, catalogues and studies, with Matplotlib; the programs are in slipstep.programs."""
