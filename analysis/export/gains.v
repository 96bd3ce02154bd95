(* ---- Gains: V, and integrals J beside it, rise by no more than w lets them ---- *)

Definition bounded_in_time (n : nat) (P now next : list (list Z)) (low turn supply S : list term) : bool :=
  nonneg n (bilinear P now now ++ low) &&
  nonneg n (times (-1) (bilinear P now next ++ bilinear P next now ++ turn) ++ times (-1) (supply ++ S)).
Definition bounded_by_steps (n : nat) (P now next : list (list Z)) (supply S : list term) : bool :=
  nonneg n (bilinear P now now) &&
  nonneg n (bilinear P now now ++ times (-1) (bilinear P next next) ++ times (-1) (supply ++ S)).

Lemma V_at_rest : forall P fs gs z, (forall f, In f fs -> dot f z = 0) -> value (bilinear P fs gs) z = 0.
Proof.
  intros P fs gs z; revert P; induction fs as [|f fs IH]; intros [|row P] H; cbn [bilinear value]; try reflexivity.
  rewrite (H f (or_introl eq_refl)), (IH P); [ring|intros g G; apply H; now right].
Qed.

Theorem gain_in_time : forall n P now next low turn supply S (z : R -> list R) (J E : R -> R),
  bounded_in_time n P now next low turn supply S = true ->
  (forall t, length (z t) = n) -> flows z now next ->
  (forall t, 0 < t -> value low (z t) <= J t) ->
  (forall t, 0 < t -> derivable_pt_lim J t (value turn (z t))) ->
  (forall t, 0 < t -> derivable_pt_lim E t (value supply (z t))) ->
  (forall t, 0 < t -> 0 <= value S (z t)) ->
  forall s t, 0 < s -> s <= t -> (forall f, In f now -> dot f (z s) = 0) -> J s = 0 -> E t <= E s.
Proof.
  intros n P now next low turn supply S z J E test len F above DJ DE class s t Hs st rest none.
  unfold bounded_in_time in test; rewrite andb_true_iff in test; destruct test as [nn falls].
  set (v := fun t => value (bilinear P now now) (z t)).
  set (v' := fun t => value (bilinear P now next) (z t) + value (bilinear P next now) (z t)).
  assert (D : forall u, 0 < u -> derivable_pt_lim (fun u => v u + (J u + E u)) u
      (v' u + (value turn (z u) + value supply (z u)))).
  { intros u Hu; apply (derivable_pt_lim_plus v (fun u => J u + E u)); [now apply flow_bilinear|].
    apply (derivable_pt_lim_plus J E); auto. }
  assert (K : v t + (J t + E t) <= v s + (J s + E s)).
  { apply (nonincreasing _ _ D); [|exact Hs|exact st]; intros u Hu.
    pose proof (nonneg_sound n _ (z u) falls (len u)) as L.
    rewrite !value_app, !value_times, !value_app in L; fold (v' u) in L.
    pose proof (class u Hu); unfold v'; lra. }
  pose proof (nonneg_sound n _ (z t) nn (len t)) as M; rewrite value_app in M; fold (v t) in M.
  pose proof (above t ltac:(lra)).
  assert (v s = 0) by (apply V_at_rest; exact rest); lra.
Qed.

Theorem gain_by_steps : forall n P now next supply S (z : nat -> list R),
  bounded_by_steps n P now next supply S = true ->
  (forall t, length (z t) = n) -> (forall t, at_ now (z (Datatypes.S t)) = at_ next (z t)) ->
  (forall t, 0 <= value S (z t)) -> (forall f, In f now -> dot f (z 0%nat) = 0) ->
  forall k, sum_f_R0 (fun t => value supply (z t)) k <= 0.
Proof.
  intros n P now next supply S z test len step class rest k.
  unfold bounded_by_steps in test; rewrite andb_true_iff in test; destruct test as [nn falls].
  set (v := fun t => value (bilinear P now now) (z t)).
  assert (next_v : forall u, v (Datatypes.S u) + value supply (z u) <= v u).
  { intro u; pose proof (nonneg_sound n _ (z u) falls (len u)) as L.
    rewrite !value_app, !value_times, !value_app in L; fold (v u) in L; pose proof (class u).
    assert (E : value (bilinear P next next) (z u) = v (Datatypes.S u)).
    { unfold v; rewrite !value_bilinear, step; reflexivity. }
    rewrite E in L; lra. }
  assert (K : v (Datatypes.S k) + sum_f_R0 (fun t => value supply (z t)) k <= v 0%nat).
  { induction k as [|k IH]; cbn [sum_f_R0]; [apply next_v|].
    pose proof (next_v (Datatypes.S k)); lra. }
  pose proof (nonneg_sound n _ (z (Datatypes.S k)) nn (len _)) as M; fold (v (Datatypes.S k)) in M.
  assert (v 0%nat = 0) by (apply V_at_rest; exact rest); lra.
Qed.
