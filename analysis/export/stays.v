(* ---- A form that depends on time along a solution of d x' = A x: it falls from the beginning to the end of a step ---- *)

Fixpoint row_size (u : list Z) : Z := match u with a :: u' => (Z.abs a + row_size u')%Z | [] => 0%Z end.
Fixpoint size_of (M : triangle) : Z := match M with (a, v) :: M' => (Z.abs a + row_size v + size_of M')%Z | [] => 0%Z end.
Fixpoint diagonal (n : nat) (c : Z) : triangle := match n with O => [] | S k => (c, []) :: diagonal k c end.
Fixpoint lie (i : nat) (M : triangle) (A : list (list Z)) : triangle :=
  match M, A with
  | (a, v) :: M', r :: A' => madd (product 1 r (repeat 0%Z i ++ a :: v))
      (madd (product 1 (repeat 0%Z i ++ [1%Z]) (combine_forms v A')) (lie (S i) M' A'))
  | _, _ => []
  end.
Fixpoint polar (M : triangle) (z w : list R) : R :=
  match M, z, w with
  | (a, v) :: M', x :: z', y :: w' => 2 * IZR a * x * y + 2 * (y * dot v z' + x * dot v w') + polar M' z' w'
  | _, _, _ => 0
  end.

Lemma row_size_nonneg : forall u, 0 <= IZR (row_size u).
Proof. induction u as [|a u IH]; cbn [row_size]; [lra|]; rewrite plus_IZR, abs_IZR; pose proof (Rabs_pos (IZR a)); lra. Qed.
Lemma size_nonneg : forall M, 0 <= IZR (size_of M).
Proof.
  induction M as [|[a v] M IH]; cbn [size_of]; [lra|]; rewrite !plus_IZR, abs_IZR.
  pose proof (Rabs_pos (IZR a)); pose proof (row_size_nonneg v); lra.
Qed.
Lemma beside_bound : forall v x z, Rabs (2 * x * dot v z) <= IZR (row_size v) * (x * x + norm2 z).
Proof.
  induction v as [|a v IH]; intros x [|y z]; cbn [dot row_size norm2].
  - rewrite Rmult_0_r, Rabs_R0; lra.
  - rewrite Rmult_0_r, Rabs_R0; lra.
  - rewrite Rmult_0_r, Rabs_R0, plus_IZR, abs_IZR; pose proof (Rabs_pos (IZR a)); pose proof (row_size_nonneg v); nra.
  - replace (2 * x * (IZR a * y + dot v z)) with (IZR a * (2 * x * y) + 2 * x * dot v z) by ring.
    apply Rle_trans with (1 := Rabs_triang _ _); rewrite plus_IZR, abs_IZR, Rabs_mult.
    specialize (IH x z); pose proof (Rabs_pos (IZR a)); pose proof (row_size_nonneg v); pose proof (norm2_nonneg z).
    assert (Rabs (2 * x * y) <= x * x + y * y).
    { apply Rabs_le; pose proof (Rle_0_sqr (x - y)); pose proof (Rle_0_sqr (x + y)); unfold Rsqr in *; lra. }
    assert (Rabs (IZR a) * Rabs (2 * x * y) <= Rabs (IZR a) * (x * x + y * y)) by (apply Rmult_le_compat_l; lra).
    pose proof (Rmult_le_pos _ _ (Rabs_pos (IZR a)) (norm2_nonneg z)).
    pose proof (Rmult_le_pos _ _ (row_size_nonneg v) (Rle_0_sqr y)); unfold Rsqr in *; lra.
Qed.
Lemma size_bound : forall M z, Rabs (qf M z) <= IZR (size_of M) * norm2 z.
Proof.
  induction M as [|[a v] M IH]; intros [|x z]; cbn [qf size_of norm2]; try (rewrite Rabs_R0; lra).
  specialize (IH z); pose proof (beside_bound v x z) as B; rewrite !plus_IZR, abs_IZR.
  apply Rle_trans with (1 := Rabs_triang _ _).
  apply Rle_trans with (Rabs (IZR a * (x * x)) + Rabs (2 * x * dot v z) + Rabs (qf M z)).
  { apply Rplus_le_compat_r, Rabs_triang. }
  rewrite Rabs_mult, (Rabs_right (x * x)) by nra.
  pose proof (Rabs_pos (IZR a)); pose proof (row_size_nonneg v); pose proof (size_nonneg M); pose proof (norm2_nonneg z); nra.
Qed.
Lemma qf_diagonal : forall n c z, length z = n -> qf (diagonal n c) z = IZR c * norm2 z.
Proof.
  induction n as [|n IH]; intros c [|x z] L; try discriminate; cbn [diagonal qf norm2 dot]; [ring|].
  rewrite IH by (cbn in L; lia); ring.
Qed.

Lemma dot_pad : forall i u z, dot (repeat 0%Z i ++ u) z = dot u (skipn i z).
Proof.
  induction i as [|i IH]; intros u [|x z]; cbn [repeat app dot skipn]; try reflexivity; [symmetry; apply dot_nil|].
  rewrite IH; ring.
Qed.
Lemma skipn_tl : forall (T : Type) i (z : list T), skipn (S i) z = tl (skipn i z).
Proof. induction i as [|i IH]; intros [|x z]; try reflexivity; exact (IH z). Qed.
Lemma qf_lie : forall M i A z, qf (lie i M A) z = polar M (skipn i z) (at_ A z).
Proof.
  induction M as [|[a v] M IH]; intros i [|r A] z; cbn [lie at_ map]; try (cbn [qf polar]; destruct (skipn i z); reflexivity).
  rewrite !qf_add, !qf_product, !dot_pad, dot_combine, IH, skipn_tl.
  destruct (skipn i z) as [|x w]; cbn [polar dot tl].
  - fold (at_ A z); destruct M as [|[b q] M]; cbn [polar]; ring.
  - fold (at_ A z); ring.
Qed.
Lemma dot_part : forall c v w, dot v (map (fun y => y / c) w) = dot v w / c.
Proof. intros c; induction v as [|a v IH]; intros [|y w]; cbn [dot map]; try (unfold Rdiv; ring); rewrite IH; unfold Rdiv; ring. Qed.
Lemma polar_part : forall c M z w, polar M z (map (fun y => y / c) w) = polar M z w / c.
Proof.
  intros c; induction M as [|[a v] M IH]; intros [|x z] [|y w]; cbn [polar map]; try (unfold Rdiv; ring).
  rewrite IH, dot_part; unfold Rdiv; ring.
Qed.

(* What is told by components. *)
Lemma dot_flow : forall (f : nat -> R -> R) f' t v a m, (forall i, (a <= i < a + m)%nat -> derivable_pt_lim (f i) t (f' i)) ->
  derivable_pt_lim (fun t => dot v (map (fun i => f i t) (seq a m))) t (dot v (map f' (seq a m))).
Proof.
  intros f f' t; induction v as [|c v IH]; intros a [|m] D; cbn [dot seq map]; try apply derivable_pt_lim_const.
  apply (derivable_pt_lim_plus (fun t => IZR c * f a t) (fun t => dot v (map (fun i => f i t) (seq (S a) m)))).
  - apply (derivable_pt_lim_scal (f a)), D; lia.
  - apply IH; intros i I; apply D; lia.
Qed.
Lemma qf_flow : forall (f : nat -> R -> R) f' t M a m, (forall i, (a <= i < a + m)%nat -> derivable_pt_lim (f i) t (f' i)) ->
  derivable_pt_lim (fun t => qf M (map (fun i => f i t) (seq a m))) t
    (polar M (map (fun i => f i t) (seq a m)) (map f' (seq a m))).
Proof.
  intros f f' t; induction M as [|[c v] M IH]; intros a [|m] D; cbn [qf polar seq map]; try apply derivable_pt_lim_const.
  assert (Da : derivable_pt_lim (f a) t (f' a)) by (apply D; lia).
  assert (Dv := dot_flow f f' t v (S a) m ltac:(intros i I; apply D; lia)).
  set (g := fun t => dot v (map (fun i => f i t) (seq (S a) m))) in *.
  apply (derivable_same (fun t => (IZR c * (f a t * f a t) + 2 * (f a t * g t)) + qf M (map (fun i => f i t) (seq (S a) m))) _ t
    (IZR c * (f' a * f a t + f a t * f' a) + 2 * (f' a * g t + f a t * dot v (map f' (seq (S a) m)))
      + polar M (map (fun i => f i t) (seq (S a) m)) (map f' (seq (S a) m)))).
  - intro s; unfold g; ring.
  - unfold g; ring.
  - apply (derivable_pt_lim_plus (fun t => IZR c * (f a t * f a t) + 2 * (f a t * g t))
      (fun t => qf M (map (fun i => f i t) (seq (S a) m)))); [|apply IH; intros i I; apply D; lia].
    apply (derivable_pt_lim_plus (fun t => IZR c * (f a t * f a t)) (fun t => 2 * (f a t * g t))).
    + apply (derivable_pt_lim_scal (fun t => f a t * f a t)), (derivable_pt_lim_mult (f a) (f a)); assumption.
    + apply (derivable_pt_lim_scal (fun t => f a t * g t)), (derivable_pt_lim_mult (f a) g); assumption.
Qed.

(* V = sum_k s^k R_k, s = (t - a)/h with h = d p/q, of any forms R_k: where d x' = A x, q h V' = sum_k s^k E_k. *)
Fixpoint over (Rs : list triangle) (k : nat) (s : R) (z : list R) : R :=
  match Rs with [] => 0 | M :: r => s ^ k * qf M z + over r (S k) s z end.
Fixpoint errors (k : nat) (p q : Z) (A : list (list Z)) (Rs : list triangle) : list triangle :=
  match Rs with
  | [] => []
  | M :: r => madd (mscale p (lie 0 M A)) (mscale (q * Z.of_nat (S k)) (hd [] r)) :: errors (S k) p q A r
  end.

Definition solves (n : nat) (d : Z) (A : list (list Z)) (f : nat -> R -> R) : Prop :=
  forall i t, (i < n)%nat -> derivable_pt_lim (f i) t (dot (nth i A []) (listed n (fun i => f i t)) / IZR d).
Definition at_once (n : nat) (f : nat -> R -> R) (t : R) : list R := listed n (fun i => f i t).

Lemma rows_by_place : forall c z A,
  map (fun i => dot (nth i A []) z / c) (seq 0 (length A)) = map (fun y => y / c) (at_ A z).
Proof.
  intros c z; induction A as [|row A IH]; [reflexivity|]; cbn [length seq map nth at_]; f_equal.
  rewrite <- seq_shift, map_map; exact IH.
Qed.
Lemma solution_form : forall n d A f M t, length A = n -> solves n d A f ->
  derivable_pt_lim (fun t => qf M (at_once n f t)) t (qf (lie 0 M A) (at_once n f t) / IZR d).
Proof.
  intros n d A f M t L S0; unfold at_once, listed.
  apply (derivable_same (fun t => qf M (map (fun i => f i t) (seq 0 n))) _ t
    (polar M (map (fun i => f i t) (seq 0 n)) (map (fun i => dot (nth i A []) (listed n (fun i => f i t)) / IZR d) (seq 0 n))));
    [reflexivity| |apply qf_flow; intros i I; apply S0; lia].
  rewrite qf_lie; cbn [skipn]; fold (listed n (fun i => f i t)); set (z := listed n (fun i => f i t)).
  rewrite <- polar_part, <- L; f_equal; apply rows_by_place.
Qed.

Lemma power_flow : forall k a h t, h <> 0 -> derivable_pt_lim (fun t => ((t - a) / h) ^ S k) t (INR (S k) * ((t - a) / h) ^ k / h).
Proof.
  intros k a h t nz.
  apply (derivable_pt_lim_comp (fun t => (t - a) / h) (fun s => s ^ S k)); [|exact (derivable_pt_lim_pow ((t - a) / h) (S k))].
  apply (derivable_same (fun t => / h * (t - a)) _ t (/ h * (1 - 0))); [intro; field; exact nz|ring|].
  apply (derivable_pt_lim_scal (fun t => t - a)), (derivable_pt_lim_minus id (fun _ => a));
    [apply derivable_pt_lim_id|apply derivable_pt_lim_const].
Qed.
Lemma over_flow : forall n d A p q f a t, length A = n -> solves n d A f -> IZR d <> 0 -> IZR p <> 0 -> IZR q <> 0 ->
  let h := IZR d * IZR p / IZR q in forall Rs k,
  derivable_pt_lim (fun t => over Rs (S k) ((t - a) / h) (at_once n f t)) t
    ((IZR q * INR (S k) * ((t - a) / h) ^ k * qf (hd [] Rs) (at_once n f t)
      + over (errors (S k) p q A Rs) (S k) ((t - a) / h) (at_once n f t)) / (IZR q * h)).
Proof.
  intros n d A p q f a t L S0 nd np nq h.
  assert (nh : h <> 0) by (unfold h, Rdiv; repeat apply Rmult_integral_contrapositive_currified; try apply Rinv_neq_0_compat; assumption).
  induction Rs as [|M Rs IH]; intro k.
  - cbn [over errors hd qf]; replace (_ / _) with 0 by (field; split; assumption); apply derivable_pt_lim_const.
  - specialize (IH (S k)); cbn [over errors hd].
    eapply derivable_same; [intro; reflexivity| |apply (derivable_pt_lim_plus _ _ _ _ _ (derivable_pt_lim_mult
      (fun t => ((t - a) / h) ^ S k) (fun t => qf M (at_once n f t)) t _ _ (power_flow k a h t nh) (solution_form n d A f M t L S0)) IH)].
    rewrite qf_add, !qf_scale, mult_IZR, <- INR_IZR_INZ; set (u := (t - a) / h); set (T := over _ _ u _); clearbody u T.
    unfold h; field; repeat split; assumption.
Qed.

(* One piece: Q before, after that; the series of the flow, each form rounded, with D less at the first power. *)
Fixpoint series (m k : nat) (p q : Z) (A : list (list Z)) (M : triangle) : list triangle :=
  match m with
  | O => [M]
  | S j => M :: series j (S k) p q A (mdiv (q * Z.of_nat (S k)) (mscale (- p) (lie 0 M A)))
  end.
Definition sizes (Rs : list triangle) : Z := fold_right (fun M s => (size_of M + s)%Z) 0%Z Rs.
Definition piece_ok (n m : nat) (d D : Z) (A : list (list Z)) (p q : Z) (Q after : triangle) : bool :=
  let Rs := Q :: series m 1 p q A (madd (mdiv q (mscale (- p) (lie 0 Q A))) (diagonal n (- D))) in
  let Es := errors 0 p q A Rs in
  (size_of (madd (hd [] Es) (diagonal n (q * D))) + sizes (tl Es) <=? q * D)%Z &&
  (size_of (madd (fold_right madd [] Rs) (madd (mscale (-1) after) (diagonal n (- (2 * D))))) <=? D)%Z.

Lemma over_bound : forall s z, 0 <= s <= 1 -> forall Rs k, over Rs k s z <= IZR (sizes Rs) * norm2 z.
Proof.
  intros s z [s0 s1]; pose proof (norm2_nonneg z) as N; induction Rs as [|M Rs IH]; intro k; cbn [over sizes fold_right]; [lra|].
  specialize (IH (S k)); unfold sizes in IH; rewrite plus_IZR.
  pose proof (size_bound M z) as B; pose proof (Rle_abs (qf M z)); pose proof (Rabs_pos (qf M z)).
  pose proof (pow_le s k s0) as P0; pose proof (pow_incr s 1 k (conj s0 s1)) as P1; rewrite pow1 in P1.
  assert (s ^ k * qf M z <= s ^ k * Rabs (qf M z)) by (apply Rmult_le_compat_l; assumption).
  assert (s ^ k * Rabs (qf M z) <= 1 * Rabs (qf M z)) by (apply Rmult_le_compat_r; assumption).
  lra.
Qed.
Lemma over_start : forall z Rs k, over Rs (S k) 0 z = 0.
Proof. intros z; induction Rs as [|M Rs IH]; intro k; cbn [over]; [reflexivity|]; rewrite IH, pow_i by lia; ring. Qed.
Lemma over_end : forall z Rs k, over Rs k 1 z = qf (fold_right madd [] Rs) z.
Proof. intros z; induction Rs as [|M Rs IH]; intro k; cbn [over fold_right]; [reflexivity|]; rewrite IH, pow1, qf_add; ring. Qed.

Lemma piece_falls : forall n m d D A p q Q after f a, piece_ok n m d D A p q Q after = true ->
  (0 < d)%Z -> (0 < q)%Z -> (0 < p)%Z -> length A = n -> solves n d A f ->
  qf after (at_once n f (a + IZR d * IZR p / IZR q)) + IZR D * norm2 (at_once n f (a + IZR d * IZR p / IZR q))
    <= qf Q (at_once n f a).
Proof.
  intros n m d D A p q Q after f a test dpos qpos ppos L S0; unfold piece_ok in test; cbv zeta in test.
  set (r := series m 1 p q A _) in test; clearbody r; cbn [errors hd tl] in test.
  set (E := madd _ (mscale (q * Z.of_nat 1) (hd [] r))) in test; apply andb_true_iff in test as [tail jump].
  apply IZR_lt in dpos, qpos, ppos; set (h := IZR d * IZR p / IZR q).
  assert (hpos : 0 < h) by (unfold h; apply Rdiv_lt_0_compat; [now apply Rmult_lt_0_compat|exact qpos]).
  set (v := fun t => over (Q :: r) 0 ((t - a) / h) (at_once n f t)).
  set (v' := fun t => (qf E (at_once n f t) + over (errors 1 p q A r) 1 ((t - a) / h) (at_once n f t)) / (IZR q * h)).
  assert (Dv : forall t, derivable_pt_lim v t (v' t)).
  { intro t; unfold v; cbn [over].
    eapply derivable_same; [| |apply (derivable_pt_lim_plus (fun t => qf Q (at_once n f t)) _ _ _ _
      (solution_form n d A f Q t L S0) (over_flow n d A p q f a t L S0 ltac:(lra) ltac:(lra) ltac:(lra) r 0))].
    - intro u; unfold plus_fct; fold h; cbn [pow]; ring.
    - fold h; unfold v', E; rewrite qf_add, !qf_scale, mult_IZR; cbn [pow INR]; change (IZR (Z.of_nat 1)) with 1.
      set (T := over _ 1 _ _); set (U := qf (lie 0 Q A) _); set (W := qf (hd [] r) _).
      unfold h; field; repeat split; lra. }
  assert (down : forall t, a < t < a + h -> v' t <= 0).
  { intros t T; unfold v'; set (z := at_once n f t).
    assert (U : 0 <= (t - a) / h <= 1).
    { split; [apply Rmult_le_pos; [lra|left; now apply Rinv_0_lt_compat]|].
      apply (Rmult_le_reg_r h); [exact hpos|]; unfold Rdiv; rewrite Rmult_assoc, Rinv_l; lra. }
    pose proof (over_bound _ z U (errors 1 p q A r) 1) as B; apply Z.leb_le, IZR_le in tail.
    pose proof (size_bound (madd E (diagonal n (q * D))) z) as C; pose proof (Rle_abs (qf (madd E (diagonal n (q * D))) z)).
    rewrite qf_add, qf_diagonal in * by (unfold z, at_once; apply listed_length); rewrite plus_IZR in tail.
    pose proof (Rmult_le_compat_r _ _ _ (norm2_nonneg z) tail) as K.
    apply (Rmult_le_reg_r (IZR q * h)); [now apply Rmult_lt_0_compat|].
    unfold Rdiv; rewrite Rmult_assoc, Rinv_l, Rmult_0_l by (apply Rgt_not_eq, Rmult_lt_0_compat; assumption); lra. }
  destruct (MVT_cor2 v v' a (a + h)) as [c [F C]]; [lra|intros; apply Dv|].
  pose proof (down c C) as K; assert (fall : v (a + h) <= v a) by nra.
  assert (V0 : v a = qf Q (at_once n f a)).
  { unfold v; cbn [over]; replace ((a - a) / h) with 0 by (field; lra); rewrite over_start; cbn [pow]; ring. }
  assert (V1 : v (a + h) = qf (fold_right madd [] (Q :: r)) (at_once n f (a + h))).
  { unfold v; replace ((a + h - a) / h) with 1 by (field; lra); apply over_end. }
  rewrite V0, V1 in fall; set (z := at_once n f (a + h)) in *; apply Z.leb_le, IZR_le in jump.
  pose proof (size_bound (madd (fold_right madd [] (Q :: r)) (madd (mscale (-1) after) (diagonal n (- (2 * D))))) z) as B.
  pose proof (Rle_abs (- qf (madd (fold_right madd [] (Q :: r)) (madd (mscale (-1) after) (diagonal n (- (2 * D))))) z)) as G.
  rewrite Rabs_Ropp in G; pose proof (Rmult_le_compat_r _ _ _ (norm2_nonneg z) jump) as H.
  rewrite !qf_add, qf_scale, qf_diagonal in * by (unfold z, at_once; apply listed_length).
  rewrite opp_IZR, mult_IZR in *; lra.
Qed.
