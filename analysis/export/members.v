(* ---- Several channels: states x = p(d/dt) xi, of which xi is a combination, in discrete time with shifts ---- *)

Lemma tends_to_same : forall f g l, (forall t, f t = g t) -> tends_to f l -> tends_to g l.
Proof. intros f g l E L eps pos; destruct (L eps pos) as [T H]; exists T; intros t Ht; rewrite <- E; auto. Qed.
Lemma tends_to_sum : forall f g a l m, tends_to f l -> tends_to g m -> tends_to (fun t => a * f t + g t) (a * l + m).
Proof.
  intros f g a l m F G eps pos; pose proof (Rabs_pos a).
  destruct (F (eps / (2 * (Rabs a + 1)))) as [S HS]; [apply Rdiv_lt_0_compat; lra|].
  destruct (G (eps / 2)) as [T HT]; [lra|]; exists (Rmax S T); intros t Ht.
  pose proof (Rmax_l S T); pose proof (Rmax_r S T).
  specialize (HS t ltac:(lra)); specialize (HT t ltac:(lra)).
  replace (a * f t + g t - (a * l + m)) with (a * (f t - l) + (g t - m)) by ring.
  apply Rle_lt_trans with (1 := Rabs_triang _ _); rewrite Rabs_mult.
  assert (Rabs a * Rabs (f t - l) <= eps / 2); [|lra].
  apply Rle_trans with ((Rabs a + 1) * (eps / (2 * (Rabs a + 1)))); [|right; field; lra].
  apply Rmult_le_compat; try lra; apply Rabs_pos.
Qed.

Fixpoint blend {T : Type} (a : list R) (x : nat -> T -> R) (k : nat) (t : T) : R :=
  match a with [] => 0 | c :: r => c * x k t + blend r x (S k) t end.
Fixpoint limit_of (a : list R) (c : nat -> R) (k : nat) : R :=
  match a with [] => 0 | v :: r => v * c k + limit_of r c (S k) end.
Lemma blend_limit : forall a (x : nat -> R -> R) c k,
  (forall j, (k <= j < length a + k)%nat -> tends_to (x j) (c j)) -> tends_to (blend a x k) (limit_of a c k).
Proof.
  induction a as [|v a IH]; intros x c k H; cbn [blend limit_of].
  - intros eps pos; exists 0; intros t _; rewrite Rminus_0_r, Rabs_R0; lra.
  - apply (tends_to_sum (x k) (blend a x (S k)) v); [apply H|apply IH; intros j J; apply H]; cbn [length]; lia.
Qed.
Lemma blend_limit_in_steps : forall a (x : nat -> nat -> R) c k,
  (forall j, (k <= j < length a + k)%nat -> Un_cv (x j) (c j)) -> Un_cv (blend a x k) (limit_of a c k).
Proof.
  induction a as [|v a IH]; intros x c k H; cbn [blend limit_of].
  - intros eps pos; exists O; intros t _; unfold R_dist; rewrite Rminus_0_r, Rabs_R0; lra.
  - apply (CV_plus (fun t => v * x k t) (blend a x (S k))).
    + apply (CV_mult (fun _ => v) (x k)); [|apply H; cbn [length]; lia].
      intros eps pos; exists O; intros t _; unfold R_dist; rewrite Rminus_diag_eq, Rabs_R0 by reflexivity; lra.
    + apply IH; intros j J; apply H; cbn [length]; lia.
Qed.
Lemma same_in_steps : forall f g l, (forall t, f t = g t) -> Un_cv f l -> Un_cv g l.
Proof. intros f g l E L eps pos; destruct (L eps pos) as [T H]; exists T; intros t Ht; rewrite <- E; auto. Qed.

Lemma along_flows : forall p (xi : nat -> R -> R), (forall k t, derivable_pt_lim (xi k) t (xi (S k) t)) ->
  forall t, derivable_pt_lim (along p xi) t (along p (fun k => xi (S k)) t).
Proof.
  induction p as [|c p IH]; intros xi D t; cbn [along]; [apply derivable_pt_lim_const|].
  apply (derivable_pt_lim_plus (fun t => c * xi (length p) t) (along p xi)); [|now apply IH].
  apply (derivable_pt_lim_scal (xi (length p))); apply D.
Qed.
