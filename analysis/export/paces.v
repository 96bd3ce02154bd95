(* ---- Solutions that fall more slowly than at a rate: those of the loop at that rate, times e^(-a t) ---- *)

Lemma paced_one : forall a t, exp (a * t) * exp (- (a * t)) = 1.
Proof. intros a t; rewrite <- exp_plus, Rplus_opp_r; apply exp_0. Qed.
Lemma paced_down : forall a t, derivable_pt_lim (fun t => exp (- (a * t))) t (- (a * exp (- (a * t)))).
Proof.
  intros a t; apply (derivable_same (fun t => exp (- (a * t))) _ t (exp (- (a * t)) * - (a * 1))); [reflexivity|ring|].
  apply (derivable_pt_lim_comp (fun t => - (a * t)) exp); [|apply derivable_pt_lim_exp].
  apply (derivable_pt_lim_opp (fun t => a * t)), (derivable_pt_lim_scal id), derivable_pt_lim_id.
Qed.
Lemma paced_flow : forall a f t l m, derivable_pt_lim f t l ->
  m = exp (- (a * t)) * l - a * (exp (- (a * t)) * f t) -> derivable_pt_lim (fun t => exp (- (a * t)) * f t) t m.
Proof.
  intros a f t l m D ->.
  apply (derivable_same (fun t => exp (- (a * t)) * f t) _ t (- (a * exp (- (a * t))) * f t + exp (- (a * t)) * l));
    [reflexivity|ring|].
  apply (derivable_pt_lim_mult (fun t => exp (- (a * t))) f); [apply paced_down|exact D].
Qed.
Lemma paced_continuity : forall a f t, continuity_pt f t -> continuity_pt (fun t => exp (- (a * t)) * f t) t.
Proof.
  intros a f t C; apply (continuity_pt_mult (fun t => exp (- (a * t))) f); [|exact C].
  apply derivable_continuous_pt; eexists; apply paced_down.
Qed.
